// Measured costs of this machine, the input of the simulator of executors.
#pragma once
#include "results.h"
#include "simulator.h"

namespace tandem::bench {

/// Samples of each cost in MachineCosts (ns).
struct CostSamples {
  Samples task, message, wake, resize, move, hand_over;
  /// Medians; the slowdown depends on the workload and stays 1.
  MachineCosts costs() const;
};

/// Measures the costs, for about a second. On a machine with one core the costs that need two are 0.
CostSamples measure_costs();

/// The smaller value of each cost, since disturbances only add to a measurement.
MachineCosts least(const MachineCosts& a, const MachineCosts& b);

}  // namespace tandem::bench
