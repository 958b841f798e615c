#pragma once
#include <cstdint>

#include "tandem/flowgraph/control_step.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// Decides when regions are cut anew, at the ends of its control steps. A cut that did not make loads more even is
/// taken back. One is made only if what equal loads would save until the longest control step is over is more than what
/// the last cut cost.
class Rebalancer {
 public:
  explicit Rebalancer(const RebalanceOptions& options) : options_(options), control_(options.longest_control_step) {}

  /// Whether the step that comes next ends with a measurement: then costs are counted by bodies.
  bool measures_next() const { return options_.enabled && steps_ + 1 >= control_.steps(); }

  /// Takes one step's loads (ms, busy time a thread): all ranks give the same ones, and get the same answer.
  RebalanceDecision after_step(double slowest_ms, double mean_ms);

  /// What the cut that was made or taken back cost, slowest rank.
  void learn_cost(double ms) { migration_ms_ = ms; }

 private:
  RebalanceOptions options_;
  int steps_ = 0;  // since the last measurement, and sums over them
  double slowest_ = 0, mean_ = 0;
  ControlStep control_;
  double migration_ms_ = 0;
};

}  // namespace tandem::mpi
