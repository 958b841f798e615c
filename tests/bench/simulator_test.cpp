// The simulator of executors.
#include "simulator.h"

#include <chrono>

#include "catch.h"

using namespace tandem;
using namespace tandem::bench;

namespace {

/// A step of equal tiles with `pairs` pairs each, recorded like the sequential executor's; times in ns. One pair in
/// `heavy_every` is heavy and costs ten times as much; these are narrowed one by one.
MeasuredStep step_of(std::size_t tiles, std::size_t pairs, int tile_ns, int pair_ns,
                     StepForm form = StepForm::overlapped, std::size_t heavy_every = 0) {
  std::vector<Timeline::Slice> slices;
  Timeline::Clock::time_point now;
  const auto add = [&](std::string_view name, int ns, std::uint64_t id, std::uint64_t count, bool heavy = false) {
    const auto end = now + std::chrono::nanoseconds(ns);
    slices.push_back({name, now, end, 0, id, count, heavy});
    now = end;
  };
  const bool ordered = form == StepForm::ordered;
  add("begin", 600, 0, 0);
  add("open", 400, 0, 0);
  for (std::uint64_t i = 0; i < 10; ++i) add("update", 2000, i, 0);
  add("open", 0, 1, 0);
  for (std::uint64_t i = 0; i < tiles; ++i) add("broad", tile_ns, i, pairs);
  const std::size_t all = tiles * pairs, together = heavy_every == 0 ? 4 : 1;
  if (ordered) {
    add("open", 0, 2, 0);
    for (std::uint64_t i = 0; i < 10; ++i) add("join", 1000, i, 0);
    add("open", 0, 3, 0);
  }
  // If the pairs are sorted the heavy ones come first.
  for (const bool heavy : {true, false})
    for (std::size_t i = 0; i < all; i += together) {
      const bool is_heavy = heavy_every != 0 && i % heavy_every == 0;
      if (ordered ? is_heavy != heavy : heavy) continue;
      if (ordered) add("join", 1, i / together, 0);
      add("narrow", static_cast<int>(together) * pair_ns * (is_heavy ? 10 : 1), i / together, together, is_heavy);
      if (ordered) add("join", 1, i / together, 0);
    }
  if (!ordered) {
    add("open", 0, 2, 0);
    for (std::uint64_t i = 0; i < 10; ++i) add("join", 1500, i, 0);
  }
  return read_step(slices, form);
}

double run(const MeasuredForms& step, Policy policy, int threads, Split split, const MachineCosts& costs = {},
           int steps = 1, StepForm form = StepForm::overlapped) {
  Simulator simulator(policy, threads, split, BalanceRule::busy, costs, form);
  double ns = 0;
  for (int i = 0; i < steps; ++i) ns = simulator.step(step).ns;
  return ns;
}

double run(const MeasuredStep& step, Policy policy, int threads, Split split, const MachineCosts& costs = {},
           int steps = 1) {
  return run(MeasuredForms{step, step, step}, policy, threads, split, costs, steps);
}

}  // namespace

TEST_CASE("simulator: one core takes the sum of all work, and each task costs what a task costs") {
  const MeasuredStep step = step_of(100, 40, 5000, 300);
  CHECK(step.pairs() == 4000);
  CHECK(step.work_ns() == Approx(1000 + 20'000 + 500'000 + 1'200'000 + 15'000));
  CHECK(run(step, Policy::sequential, 1, {}) == Approx(step.work_ns()));
  // 20 blocks, 100 tiles that each end a segment, 31 batches filled within one, 32 batches.
  const double with_costs = run(step, Policy::sequential, 1, {}, {.task = 100});
  CHECK(with_costs > step.work_ns() + 100 * 150);
  CHECK(with_costs < step.work_ns() + 100 * 190);
}

TEST_CASE("simulator: no policy beats an even share, and conserving ones come near it") {
  for (const auto& [tile_ns, pair_ns] : {std::pair{5000, 300}, {50'000, 100}, {1000, 2000}}) {
    const MeasuredStep step = step_of(400, 40, tile_ns, pair_ns);
    for (const int threads : {2, 4, 16}) {
      const double share = step.work_ns() / threads;
      CAPTURE(tile_ns, pair_ns, threads);
      for (const Policy policy : {Policy::barrier, Policy::fused, Policy::strict, Policy::conserving})
        CHECK(run(step, policy, threads, {}, {}, 5) >= share);
      for (const Policy policy : {Policy::barrier, Policy::fused, Policy::conserving})
        CHECK(run(step, policy, threads, {}, {}, 5) <= 1.15 * share + 2 * (tile_ns + 40.0 * pair_ns));
    }
  }
}

TEST_CASE("simulator: a strict split lasts as long as the phase that it serves worse") {
  const MeasuredStep step = step_of(400, 40, 5000, 300);  // 2 ms and 4.8 ms
  CHECK(run(step, Policy::strict, 8, {2, 6}) == Approx(2e6 / 2).epsilon(0.1));
  CHECK(run(step, Policy::strict, 8, {1, 7}) == Approx(2e6).epsilon(0.1));
  CHECK(run(step, Policy::strict, 8, {7, 1}) == Approx(4.8e6).epsilon(0.1));
}

TEST_CASE("simulator: a dynamic split finds the best one") {
  const MeasuredStep step = step_of(400, 40, 5000, 300);
  double best = 1e300;
  for (int broad = 1; broad < 16; ++broad) best = std::min(best, run(step, Policy::strict, 16, {broad, 16 - broad}));
  CHECK(run(step, Policy::strict, 16, {}, {}, 40) <= 1.05 * best);
}

TEST_CASE("simulator: waking, moving and slowing threads is paid for") {
  const MeasuredStep step = step_of(400, 40, 5000, 300);
  const double free = run(step, Policy::conserving, 4, {2, 2});
  CHECK(run(step, Policy::conserving, 4, {2, 2}, {.wake = 100'000}) == Approx(free + 75'000).epsilon(0.02));
  CHECK(run(step, Policy::conserving, 4, {2, 2}, {.slowdown = 1.2}) == Approx(1.2 * free).epsilon(0.02));
  CHECK(run(step, Policy::conserving, 4, {2, 2}, {.sharing = 1.2}) == Approx(1.2 * free).epsilon(0.02));
  CHECK(run(step, Policy::sequential, 1, {}, {.sharing = 1.2}) == Approx(step.work_ns()));
  // The longer of two phases that take 1 and 7 parts of the time is slowed only while the other lasts.
  const MeasuredStep narrow = step_of(400, 40, 5000, 875);
  const double alone = run(narrow, Policy::strict, 2, {1, 1});
  CHECK(run(narrow, Policy::strict, 2, {1, 1}, {.slowdown = 1.2}) ==
        Approx(alone + 0.2 * 1.2 * 400 * 5000).epsilon(0.02));
}

TEST_CASE("simulator: steps in the form in which pairs are put in order first") {
  const MeasuredStep step = step_of(400, 40, 5000, 300, StepForm::ordered);
  CHECK(step.order.size() == 1);
  CHECK(step.order.front().blocks.size() == 10);
  CHECK(step.after.empty());
  CHECK(step.pairs() == 16'000);
  CHECK(step.narrow_ns(0, 16'000, false) == Approx(16'000 * 300 + 4000 * 2));
  CHECK(step.work_ns() == Approx(1000 + 20'000 + 2e6 + 10'000 + 4.8e6 + 8000));
  const MeasuredForms forms{step, step, step};
  for (const int threads : {2, 4, 16}) {
    const double share = step.work_ns() / threads;
    for (const Policy policy : {Policy::barrier, Policy::conserving}) {
      const double took = run(forms, policy, threads, {}, {}, 5, StepForm::ordered);
      CHECK(took >= share);
      CHECK(took <= 1.02 * share + 40'000);
    }
  }
}

TEST_CASE("simulator: the fastest form is found as the executors find it") {
  MeasuredStep plain = step_of(1600, 40, 5000, 300);
  plain.after.front().blocks.assign(40, 60'000);  // 1.2 of 15 ms on two threads can be gained
  MeasuredForms forms{plain, plain, step_of(1600, 40, 5000, 200, StepForm::ordered)};
  Simulator chooses(Policy::conserving, 2, {}, BalanceRule::busy, {});
  for (int i = 0; i < 12; ++i) chooses.step(forms);
  CHECK(chooses.step(forms).form == StepForm::ordered);
  std::swap(forms.ordered, forms.overlapped);
  forms.ordered = step_of(1600, 40, 5000, 300, StepForm::ordered);
  forms.overlapped = step_of(1600, 40, 5000, 200);
  forms.overlapped.after = plain.after;
  Simulator stays(Policy::conserving, 2, {}, BalanceRule::busy, {});
  int others = 0;
  for (int i = 0; i < 60; ++i) others += stays.step(forms).form != StepForm::overlapped;
  CHECK(others > 0);
  CHECK(others < 10);
  Simulator fused(Policy::fused, 2, {}, BalanceRule::busy, {});
  for (int i = 0; i < 30; ++i) CHECK(fused.step(forms).form == StepForm::overlapped);
  // Less than 0.3 ms is not shared.
  const MeasuredStep small = step_of(10, 40, 5000, 100);
  Simulator caller(Policy::conserving, 2, {}, BalanceRule::busy, {});
  caller.step({small, small, small});
  CHECK(caller.step({small, small, small}).form == StepForm::caller);
}

TEST_CASE("simulator: heavy pairs begin before others, whatever the form") {
  // 20 heavy pairs of 500 us among 4000 of 50: in their order, the last of them would begin near the end.
  for (const StepForm form : {StepForm::overlapped, StepForm::ordered}) {
    CAPTURE(name(form));
    const MeasuredStep step = step_of(100, 40, 1000, 50'000, form, 200);
    CHECK(step.has_heavy());
    CHECK(step.narrow_ns(0, 4000, true) >= 20 * 500'000);
    CHECK(step.narrow_ns(0, 4000, false) >= 3980 * 50'000);
    CHECK(step.narrow_ns(190, 210, true) == Approx(500'000).epsilon(0.001));
    CHECK(step.narrow_ns(190, 210, false) == Approx(19 * 50'000).epsilon(0.001));
    const double took = run({step, step, step}, Policy::conserving, 16, {}, {}, 5, form);
    CHECK(took <= step.work_ns() / 16 + 100'000);
  }
}

TEST_CASE("simulator: the costliest of the heavy pairs begin first") {
  // 60 heavy pairs of 100 us, which fit the queue, and one of 4 ms among the last to be found.
  std::vector<Timeline::Slice> slices;
  Timeline::Clock::time_point now{};
  const auto add = [&](std::string_view name, int ns, std::uint64_t id, std::uint64_t pairs, bool heavy) {
    const auto end = now + std::chrono::nanoseconds(ns);
    slices.push_back({name, now, end, 0, id, pairs, heavy});
    now = end;
  };
  add("begin", 1000, 0, 0, false);
  add("open", 0, 0, 0, false);
  for (std::uint64_t tile = 0; tile < 20; ++tile) add("broad", 1000, tile, 3, false);
  for (std::uint64_t pair = 0; pair < 60; ++pair) add("narrow", pair == 55 ? 4'000'000 : 100'000, pair, 1, true);
  const MeasuredStep step = read_step(slices, StepForm::overlapped);
  CHECK(step.costliest_ns() == Approx(4e6));
  // In the first step it is not known.
  CHECK(run(step, Policy::conserving, 4, {}, {}, 1) > 4.9e6);
  CHECK(run(step, Policy::conserving, 4, {}, {}, 2) < 4.3e6);
}

TEST_CASE("simulator: of several runs each piece has its median time") {
  const MeasuredStep step =
      typical_step({step_of(100, 40, 5000, 200), step_of(100, 40, 4000, 300), step_of(100, 40, 9000, 100)});
  CHECK(step.work_ns() == Approx(1000 + 20'000 + 500'000 + 800'000 + 15'000));
  // Their sum is the median sum: here the second's, though the first has both medians.
  const MeasuredStep skewed =
      typical_step({step_of(100, 40, 5000, 200), step_of(100, 40, 4000, 300), step_of(100, 40, 9000, 200)});
  CHECK(skewed.work_ns() == Approx(1000 + 20'000 + 400'000 + 1'200'000 + 15'000));
  CHECK(skewed.tiles.front().ns / skewed.narrow_ns(0, 1, false) == Approx(5000.0 / 200));
  const MeasuredStep of_two = typical_step({step_of(100, 40, 5000, 200), step_of(100, 40, 4000, 300)});
  CHECK(of_two.work_ns() == Approx(1000 + 20'000 + 450'000 + 1'000'000 + 15'000));
  CHECK(of_two.tiles.front().ns == Approx(4500));
  CHECK_THROWS_AS(typical_step({}), std::logic_error);
  CHECK_THROWS_AS(typical_step({step_of(100, 40, 1, 1), step_of(90, 40, 1, 1)}), std::logic_error);
}
