#pragma once
#include <functional>

#include "results.h"
#include "simulator.h"

namespace tandem::bench {

/// Measurements of what MachineCosts holds (ns).
struct CostSamples {
  Samples task, message, wake, resize, move, hand_over;
  /// Medians; the slowdown is the workload's and stays 1.
  MachineCosts costs() const;
};

/// Takes about a second. On a machine with one core what needs a second one is 0.
CostSamples measure_costs();

/// The time of a thread's work when another thread works too, over its time alone, >= 1: the median of some runs of
/// `work`, which must be safe to run on two threads at once (each call gets the thread's number, 0 or 1).
double measure_slowdown(const std::function<void(int)>& work, int runs);

}  // namespace tandem::bench
