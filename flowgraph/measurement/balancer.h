// The balance of threads between broad and narrow phase.
#pragma once
#include <cstdint>

#include "tandem/flowgraph/control_step.h"
#include "tandem/flowgraph/report.h"

namespace tandem {

/// Moves threads between the two phases from measured times (Avril, Gouranton and Arnaldi, ICAT 2010, section 4), at
/// the ends of its control steps. A change that did not make the step faster is taken back.
///
/// BalanceRule::paper compares the phases' times (computing time a thread of the phase) and moves one thread to the
/// longer one; it verifies on the step's time. BalanceRule::busy goes at once to the split that serves the busy times
/// best, also between decisions when the load changes sides, and verifies on time per unit of work, so that a rising
/// load does not count against a good change.
class Balancer {
 public:
  /// `fixed` dynamic: starts with half of `threads` for each phase. threads >= 2.
  Balancer(int threads, Split fixed, BalanceRule rule, BalanceFunction own_rule = {});

  Split split() const { return split_; }
  /// Takes the measurements of one step; the split it returns in `after` is in force from the next step on.
  BalanceDecision after_step(std::uint64_t step, const ExecutionReport& report);

 private:
  void apply_user_rule(const ExecutionReport& report, BalanceDecision& decision);
  /// Adds a step to the sums. True if the sums are to be judged now.
  bool add_to_window(const ExecutionReport& report, BalanceDecision& decision);
  /// True if the previous change improved the step; else it is to be taken back.
  void verify(BalanceDecision& decision);
  /// The split wanted in place of the present one, if any.
  void choose(BalanceDecision& decision);
  int wanted_broad() const;
  int best_broad(double broad, double narrow) const;
  void clear_window();

  int threads_;
  bool fixed_;
  BalanceRule rule_;
  BalanceFunction own_rule_;  // a user's rule: asked after every step, never taken back
  Split split_;

  // Sums over the steps since the last measurement.
  int steps_ = 0;
  double broad_ = 0, narrow_ = 0, detect_ = 0;

  ControlStep control_;
  Split before_;
};

}  // namespace tandem
