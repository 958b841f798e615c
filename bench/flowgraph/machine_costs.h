#pragma once
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

/// The least of each cost: what disturbs a measurement only adds to it.
MachineCosts least(const MachineCosts& a, const MachineCosts& b);

}  // namespace tandem::bench
