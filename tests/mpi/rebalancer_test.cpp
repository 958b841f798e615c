// When regions are cut anew.
#include "adapters/mpi/rebalancer.h"

#include "world.h"

using namespace tandem;

namespace {

// Runs steps until a decision; no step counts costs except the first and those before a cut.
BalanceAction next_action(mpi::Rebalancer& rebalancer, double slowest, double mean, int& steps) {
  for (steps = 1;; ++steps) {
    const bool counted = rebalancer.counts_next();
    const mpi::RebalanceDecision decision = rebalancer.after_step(slowest, mean);
    CHECK((decision.action != BalanceAction::change || counted));
    if (decision.action != BalanceAction::none) return decision.action;
    REQUIRE(steps < 100);
  }
}

}  // namespace

TEST_CASE("regions are cut after a step that counted costs, and a cut that did not help is taken back") {
  mpi::Rebalancer rebalancer({.enabled = true, .longest_control_step = 16, .tolerated = 1.05});
  CHECK(rebalancer.counts_next());  // the first step
  int steps = 0;
  CHECK(next_action(rebalancer, 10.2, 10, steps) == BalanceAction::keep);
  CHECK(!rebalancer.counts_next());
  CHECK(next_action(rebalancer, 20, 10, steps) == BalanceAction::change);
  CHECK(steps == 3);  // the control step, doubled, and one that counts
  CHECK(!rebalancer.counts_next());
  rebalancer.learn_cost(40);
  rebalancer.after_step(100, 10);  // caches are cold
  CHECK(next_action(rebalancer, 20, 10, steps) == BalanceAction::revert);
  rebalancer.learn_cost(30);

  SECTION("what it cost to take a cut back counts as well") {
    // 16 steps of 4 ms are less than 70 ms, and more than 40.
    CHECK(next_action(rebalancer, 14, 10, steps) == BalanceAction::keep);
    CHECK(rebalancer.after_step(14, 10).migration_ms == 70);
  }
  SECTION("what a host's own cut costs is not added to it") {
    rebalancer.note_cut();
    rebalancer.learn_cost(8);
    CHECK(rebalancer.after_step(1000, 10).migration_ms == 8);  // a cold step
    CHECK(next_action(rebalancer, 14, 10, steps) == BalanceAction::change);
  }
  SECTION("a cold step does not count against a cut") {
    CHECK(next_action(rebalancer, 20, 10, steps) == BalanceAction::change);
    rebalancer.after_step(1000, 10);
    CHECK(next_action(rebalancer, 11, 10, steps) == BalanceAction::confirm);
  }
}
