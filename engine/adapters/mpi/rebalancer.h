// The decision when regions are recomputed.
#pragma once
#include <cstdint>
#include <utility>

#include "tandem/flowgraph/control_step.h"
#include "tandem/mpi/pipeline.h"

namespace tandem::mpi {

/// Decides at the ends of its control steps when regions are recomputed. A cut that did not make loads more even is
/// reverted. A cut is made only if equal loads would save, until the end of the longest control step, more than the
/// last cut cost, including its reversal if there was one.
///
/// The cost of each body is measured only in the step before a cut, as measuring takes 20 ns a pair: a cut is made one
/// step after loads have shown the need.
class Rebalancer {
 public:
  explicit Rebalancer(const RebalanceOptions& options) : options_(options), control_(options.longest_control_step) {}

  /// True if costs are to be counted by bodies in the next step: it ends with a cut, or is the first step, so that a
  /// cut requested by the host has costs.
  bool counts_next() const { return options_.enabled && (wants_cut_ || is_first_); }

  /// Takes one step's loads (ms, busy time a thread); all ranks give the same ones, and get the same decision.
  RebalanceDecision after_step(double slowest_ms, double mean_ms);

  /// Notes the cost of the cut that was made or taken back, on the slowest rank.
  void learn_cost(double ms) { migration_ms_ = std::exchange(taken_back_, false) ? migration_ms_ + ms : ms; }
  /// Notes a cut requested by the host, whose cost the next step bears.
  void note_cut() { cold_steps_ = cold_steps; }

 private:
  static constexpr int cold_steps = 1;

  void decide(RebalanceDecision& decision);
  void verify(RebalanceDecision& decision);

  RebalanceOptions options_;
  int steps_ = 0;                  // steps since the last measurement
  int measured_ = 0;               // of these, steps without cold ones
  int cold_steps_ = 0;             // number of next steps that bear the cost of a cut: caches are cold, boxes new
  double slowest_ = 0, mean_ = 0;  // sums over the measured steps
  ControlStep control_;
  bool is_first_ = true;
  bool wants_cut_ = false;
  bool taken_back_ = false;  // the last cut was, at a cost that is yet to be noted
  double migration_ms_ = 0;
};

}  // namespace tandem::mpi
