// The balancing of threads.
#include "measurement/balancer.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.h"

using namespace tandem;

namespace {

/// A model of a machine: a step lasts as long as the phase that its threads serve worse.
ExecutionReport measured(Split split, double broad_work, double narrow_work) {
  ExecutionReport report;
  report.split = split;
  report.broad_ms = broad_work;
  report.narrow_ms = narrow_work;
  report.detect_ms = std::max(broad_work / split.broad, narrow_work / split.narrow);
  return report;
}

}  // namespace

TEST_CASE("control steps double while nothing changes, and after a change are one step long or twice what they were") {
  ControlStep control(16);
  for (const int steps : {1, 2, 4, 8, 16, 16}) {
    CHECK(control.steps() == steps);
    control.keep();
  }
  control.change(5.0, 2);
  CHECK(control.steps() == 2);
  CHECK(control.verifies());
  CHECK(control.confirm(4.9));
  CHECK(control.steps() == 1);
  CHECK(!control.verifies());
  control.keep();
  control.change(4.9);
  CHECK(control.measured_before() == 4.9);
  CHECK(!control.confirm(4.9));
  CHECK(control.steps() == 4);
}

TEST_CASE("both rules find the best split of a steady load and stay there") {
  for (const BalanceRule rule : {BalanceRule::paper, BalanceRule::busy})
    for (const int threads : {2, 3, 4, 8, 16})
      for (const double broad : {1.0, 3.0, 10.0, 30.0}) {
        const double narrow = 10.0;
        CAPTURE(name(rule), threads, broad);
        double best = 1e9;
        for (int x = 1; x < threads; ++x) best = std::min(best, measured({x, threads - x}, broad, narrow).detect_ms);
        Balancer balancer(threads, {}, rule);
        std::uint64_t step = 0;
        for (; step < 300; ++step) balancer.after_step(step, measured(balancer.split(), broad, narrow));
        double sum = 0;
        for (; step < 600; ++step) {
          const auto report = measured(balancer.split(), broad, narrow);
          sum += report.detect_ms;
          balancer.after_step(step, report);
        }
        CHECK(sum / 300 <= 1.1 * best);
      }
}

TEST_CASE("the paper's rule moves one thread, verifies it, and looks less and less often while nothing changes") {
  Balancer balancer(8, {}, BalanceRule::paper);
  CHECK(balancer.split() == Split{4, 4});
  const auto first = balancer.after_step(0, measured({4, 4}, 1, 10));
  CHECK(first.action == BalanceAction::change);
  CHECK(first.after == Split{3, 5});
  const auto second = balancer.after_step(1, measured({3, 5}, 1, 10));
  CHECK(second.action == BalanceAction::confirm);
  CHECK(second.measure < second.measure_before);
  CHECK(second.control_step == 1);

  int longest = 0;
  for (std::uint64_t step = 2; step < 400; ++step)
    longest = std::max(longest, balancer.after_step(step, measured(balancer.split(), 1, 10)).control_step);
  CHECK(longest >= 32);
  CHECK(balancer.split() == Split{1, 7});
}

TEST_CASE("a change that does not make the step faster is taken back") {
  for (const BalanceRule rule : {BalanceRule::paper, BalanceRule::busy}) {
    CAPTURE(name(rule));
    Balancer balancer(4, {}, rule);
    const auto change = balancer.after_step(0, measured({2, 2}, 1, 10));
    REQUIRE(change.action == BalanceAction::change);
    auto slower = measured(change.after, 1, 10);
    slower.detect_ms = 100;
    const auto revert = balancer.after_step(1, slower);
    CHECK(revert.action == BalanceAction::revert);
    CHECK(revert.after == Split{2, 2});
    CHECK(revert.control_step > 1);
  }
}

TEST_CASE("verification by time per work keeps a good change under a rising load") {
  Balancer balancer(4, {}, BalanceRule::busy);
  const auto change = balancer.after_step(0, measured({2, 2}, 1, 10));
  REQUIRE(change.action == BalanceAction::change);
  CHECK(balancer.after_step(1, measured(change.after, 2, 20)).action == BalanceAction::confirm);
}

TEST_CASE("the busy rule answers an inversion of load within three steps") {
  for (const int threads : {4, 8, 16}) {
    CAPTURE(threads);
    Balancer balancer(threads, {}, BalanceRule::busy);
    std::uint64_t step = 0;
    for (; step < 500; ++step) balancer.after_step(step, measured(balancer.split(), 10, 1));
    REQUIRE(balancer.split().broad > threads / 2);
    for (int i = 0; i < 3; ++i, ++step) balancer.after_step(step, measured(balancer.split(), 1, 10));
    CHECK(balancer.split().broad <= std::max(1, threads / 4));
  }
}

TEST_CASE("a fixed split stays, and two threads have only one") {
  Balancer fixed(8, {3, 5}, BalanceRule::busy);
  for (std::uint64_t step = 0; step < 100; ++step) fixed.after_step(step, measured({3, 5}, 100, 1));
  CHECK(fixed.split() == Split{3, 5});
  Balancer two(2, {}, BalanceRule::paper);
  for (std::uint64_t step = 0; step < 100; ++step) {
    const auto decision = two.after_step(step, measured({1, 1}, 100, 1));
    CHECK(decision.action != BalanceAction::change);
    CHECK_FALSE(decision.reason.empty());
  }
  CHECK(two.split() == Split{1, 1});
}

TEST_CASE("a rule of one's own is asked after each shared step, and its number is kept within what there is") {
  std::vector<Split> told;
  int wanted = 3;
  Balancer balancer(4, {}, BalanceRule::paper, [&](const ExecutionReport& report) {
    told.push_back(report.split);
    return wanted;
  });
  CHECK(balancer.split() == Split{2, 2});
  BalanceDecision decision = balancer.after_step(0, measured(balancer.split(), 1, 1));
  CHECK(decision.action == BalanceAction::change);
  CHECK(decision.before == Split{2, 2});
  CHECK(balancer.split() == Split{3, 1});
  CHECK(balancer.after_step(1, measured(balancer.split(), 1, 1)).action == BalanceAction::keep);
  wanted = 99;
  balancer.after_step(2, measured(balancer.split(), 1, 1));
  CHECK(balancer.split() == Split{3, 1});
  wanted = -5;
  balancer.after_step(3, measured(balancer.split(), 1, 1));
  CHECK(balancer.split() == Split{1, 3});
  ExecutionReport alone = measured({1, 3}, 1, 1);
  alone.issues = bit(StepIssue::ran_on_caller);
  balancer.after_step(4, alone);
  CHECK(told == std::vector<Split>{{2, 2}, {3, 1}, {3, 1}, {3, 1}});
  Balancer fixed(4, {1, 3}, BalanceRule::busy, [](const ExecutionReport&) { return 2; });
  fixed.after_step(0, measured({1, 3}, 9, 1));
  CHECK(fixed.split() == Split{1, 3});
}
