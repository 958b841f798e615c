// Decides when regions are cut anew.
#include "rebalancer.h"

#include <utility>

namespace tandem::mpi {
namespace {

constexpr int measured_steps = 2;  // steps measured between a cut and its verification

}  // namespace

RebalanceDecision Rebalancer::after_step(double slowest_ms, double mean_ms) {
  RebalanceDecision decision;
  decision.control_step = options_.enabled ? control_.steps() : 0;
  decision.migration_ms = migration_ms_;
  is_first_ = false;
  if (!options_.enabled) {
    decision.reason = "regions stay as they are";
    return decision;
  }
  ++steps_;
  if (cold_steps_ > 0) {
    --cold_steps_;
  } else {
    ++measured_;
    slowest_ += slowest_ms;
    mean_ += mean_ms;
  }
  decision.imbalance = mean_ > 0 ? slowest_ / mean_ : 1;
  decision.gain_ms = measured_ > 0 ? (slowest_ - mean_) / measured_ : 0;
  if (std::exchange(wants_cut_, false)) {
    decision.action = BalanceAction::change;
    decision.reason = "one rank is slower than the mean";
    control_.change(decision.imbalance, cold_steps + measured_steps);
    taken_back_ = false;
    cold_steps_ = cold_steps;
  } else if (steps_ < control_.steps()) {
    decision.reason = "between two control steps";
    return decision;
  } else if (control_.verifies()) {
    verify(decision);
  } else {
    decide(decision);
  }
  if (wants_cut_) return decision;  // by the costs measured until then
  steps_ = measured_ = 0;
  slowest_ = mean_ = 0;
  decision.control_step = control_.steps();
  return decision;
}

void Rebalancer::verify(RebalanceDecision& decision) {
  if (control_.confirm(decision.imbalance)) {
    decision.action = BalanceAction::confirm;
    decision.reason = "loads became more even";
    return;
  }
  decision.action = BalanceAction::revert;
  decision.reason = "loads did not become more even";
  taken_back_ = true;
  cold_steps_ = cold_steps;
}

void Rebalancer::decide(RebalanceDecision& decision) {
  if (decision.imbalance <= options_.tolerated) {
    decision.action = BalanceAction::keep;
    decision.reason = "loads are even";
    control_.keep();
  } else if (decision.gain_ms * options_.longest_control_step <= migration_ms_) {
    decision.action = BalanceAction::keep;
    decision.reason = "migration would cost more than it saves";
    control_.keep();
  } else {
    decision.reason = "one rank is slower than the mean: costs are counted in the next step, then regions are cut";
    wants_cut_ = true;
  }
}

}  // namespace tandem::mpi
