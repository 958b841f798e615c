#include "rebalancer.h"

namespace tandem::mpi {

RebalanceDecision Rebalancer::after_step(double slowest_ms, double mean_ms) {
  RebalanceDecision decision;
  decision.control_step = control_.steps();
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
  if (steps_ < control_.steps()) {
    decision.reason = "between two control steps";
    return decision;
  }
  if (control_.verifies()) {
    if (control_.confirm(decision.imbalance)) {
      decision.action = BalanceAction::confirm;
      decision.reason = "loads became more even";
    } else {
      decision.action = BalanceAction::revert;
      decision.reason = "loads did not become more even";
    }
  } else if (decision.imbalance <= options_.tolerated) {
    decision.action = BalanceAction::keep;
    decision.reason = "loads are even";
    control_.keep();
  } else if (decision.gain_ms * options_.longest_control_step <= migration_ms_) {
    decision.action = BalanceAction::keep;
    decision.reason = "migration would cost more than it saves";
    control_.keep();
  } else {
    decision.action = BalanceAction::change;
    decision.reason = "one rank is slower than the mean";
    control_.change(decision.imbalance, 2);  // the first step after a cut pays for it: caches are cold, all boxes new
  }
  steps_ = 0;
  slowest_ = mean_ = 0;
  decision.control_step = control_.steps();
  return decision;
}

}  // namespace tandem::mpi
