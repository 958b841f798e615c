#pragma once
#include <cstdint>

#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// Decides when regions are cut anew, by the paper's control step (Balancer): looks are frequent at first, become rare
/// while nothing changes, and frequent again after a change; every change is verified at the next look, and taken back
/// if loads are no more even. A cut is made only if what equal loads would save until the longest control step is over
/// is more than what the last cut cost.
class Rebalancer {
 public:
  explicit Rebalancer(const RebalanceOptions& options) : options_(options) {}

  /// Whether the step that comes next ends with a look: then costs are counted by bodies.
  bool looks() const { return options_.enabled && steps_ + 1 >= control_step_; }

  /// Takes one step's loads (ms, busy time a thread): all ranks give the same ones, and get the same answer.
  RebalanceDecision after_step(double slowest_ms, double mean_ms);

  /// What the cut that was made or taken back cost, slowest rank.
  void learn_cost(double ms) { migration_ms_ = ms; }

 private:
  RebalanceOptions options_;
  int steps_ = 0;  // since the last look, and sums over them
  double slowest_ = 0, mean_ = 0;
  int control_step_ = 1, control_before_ = 1;
  bool verifying_ = false;
  double imbalance_before_ = 1;
  double migration_ms_ = 0;
};

}  // namespace tandem::mpi
