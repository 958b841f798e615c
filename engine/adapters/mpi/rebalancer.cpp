#include "rebalancer.h"

#include <algorithm>

namespace tandem::mpi {

RebalanceDecision Rebalancer::after_step(double slowest_ms, double mean_ms) {
  RebalanceDecision decision;
  decision.control_step = control_step_;
  decision.migration_ms = migration_ms_;
  if (!options_.enabled) {
    decision.control_step = 0;
    decision.reason = "regions stay as they are";
    return decision;
  }
  ++steps_;
  slowest_ += slowest_ms;
  mean_ += mean_ms;
  decision.imbalance = mean_ > 0 ? slowest_ / mean_ : 1;
  decision.gain_ms = (slowest_ - mean_) / steps_;
  if (steps_ < control_step_) {
    decision.reason = "between two control steps";
    return decision;
  }
  if (verifying_) {
    verifying_ = false;
    if (decision.imbalance < imbalance_before_) {
      decision.action = BalanceAction::confirm;
      decision.reason = "loads became more even";
      control_step_ = 1;
    } else {
      decision.action = BalanceAction::revert;
      decision.reason = "loads did not become more even";
      control_step_ = std::min(2 * control_before_, options_.longest_control_step);
    }
  } else if (decision.imbalance <= options_.tolerated) {
    decision.action = BalanceAction::keep;
    decision.reason = "loads are even";
    control_step_ = std::min(2 * control_step_, options_.longest_control_step);
  } else if (decision.gain_ms * options_.longest_control_step <= migration_ms_) {
    decision.action = BalanceAction::keep;
    decision.reason = "migration would cost more than it saves";
    control_step_ = std::min(2 * control_step_, options_.longest_control_step);
  } else {
    decision.action = BalanceAction::change;
    decision.reason = "one rank is slower than the mean";
    imbalance_before_ = decision.imbalance;
    control_before_ = control_step_;
    verifying_ = true;
    control_step_ = 2;  // the first step after a cut pays for it: caches are cold, all boxes are new
  }
  steps_ = 0;
  slowest_ = mean_ = 0;
  decision.control_step = control_step_;
  return decision;
}

}  // namespace tandem::mpi
