#pragma once
#include <cstdint>

#include "tandem/flowgraph/control_step.h"
#include "tandem/flowgraph/report.h"

namespace tandem {

/// Moves threads between the two phases from measured times (paper, section 4), at the ends of its control steps. A
/// change that did not make the step faster is taken back.
///
/// BalanceRule::paper compares the phases' times (computing time a thread of the phase) and moves one thread to the
/// longer one; verified on the step's time. BalanceRule::busy goes at once to the split that serves the busy times
/// best, at once too when they turn round between decisions, and verifies on time per unit of work, so that a rising
/// load does not count against a good change.
class Balancer {
 public:
  /// `fixed` dynamic: starts at half of `threads` each. threads >= 2.
  Balancer(int threads, Split fixed, BalanceRule rule, BalanceFunction own_rule = {});

  Split split() const { return split_; }
  /// Takes one step's measurements; the split it returns in `after` is in force from the next step on.
  BalanceDecision after_step(std::uint64_t step, const ExecutionReport& report);

 private:
  void ask_own_rule(const ExecutionReport& report, BalanceDecision& decision);
  /// Adds a step to the sums. Whether they are to be judged now.
  bool add_to_window(const ExecutionReport& report, BalanceDecision& decision);
  /// Whether the change before was one for the better; else it is taken back.
  void verify(BalanceDecision& decision);
  /// Another split, if one is wanted.
  void choose(BalanceDecision& decision);
  int wanted_broad() const;
  int best_broad(double broad, double narrow) const;
  void clear_window();

  int threads_;
  bool fixed_;
  BalanceRule rule_;
  BalanceFunction own_rule_;  // asked after every step, and believed
  Split split_;

  // Sums over the steps since the last measurement.
  int steps_ = 0;
  double broad_ = 0, narrow_ = 0, detect_ = 0;

  ControlStep control_;
  Split before_;
};

}  // namespace tandem
