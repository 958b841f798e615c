// Workers that stay awake between steps.
#include "flowgraph/executors/awake_workers.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <limits>
#include <optional>
#include <thread>

#include "catch.h"
#include "synthetic_work.h"
#include "tandem/flowgraph/tile_work.h"

using namespace tandem;
using namespace std::chrono_literals;

namespace {

ExecutorOptions awake(int threads, double microseconds) {
  return {.threads = threads, .sharing = {.form = StepForm::ordered, .short_step_ms = 0}, .stay_awake = microseconds};
}

}  // namespace

TEST_CASE("awake workers: the contacts are the same, with any number of threads, split and pause") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  SyntheticWork work(1500, 10.0f, 5);
  const std::uint64_t expected = hash(work.expected());
  for (const int threads : {1, 2, 5})
    for (const double microseconds : {1.0, 200.0, longest_awake})
      for (const bool strict : {false, true}) {
        CAPTURE(threads, microseconds, strict);
        ExecutorOptions options = awake(threads, microseconds);
        options.sharing = {};
        options.balance = {.rule = BalanceRule::paper, .strict = strict};
        const auto executor = make_executor(options);
        for (int step = 0; step < 12; ++step) {
          ContactList contacts;
          ExecutionReport report;
          executor->run(work, contacts, report, {}, nullptr);
          CHECK(hash(contacts) == expected);
          CHECK((threads > 1 || report.awake_ms == 0));
          if (step % 4 == 3) std::this_thread::sleep_for(300us);
        }
      }
}

TEST_CASE("awake workers: what they took is told, and nothing where none was asked for") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  TileWork work({.tiles = 64, .pairs_a_tile = 20, .tile_ns = 2000, .pair_ns = 100});
  for (const double microseconds : {0.0, longest_awake}) {
    const auto executor = make_executor(awake(2, microseconds));
    double told_ms = 0;
    // On a busy machine a worker may come too late for some steps.
    const int steps = microseconds == 0 ? 20 : 2000;
    for (int step = 0; step < steps && told_ms == 0; ++step) {
      ContactList contacts;
      ExecutionReport report;
      executor->run(work, contacts, report, {}, nullptr);
      told_ms += report.awake_ms;
      std::this_thread::sleep_for(5ms);
    }
    CHECK((told_ms > 0) == (microseconds > 0));
  }
}

TEST_CASE("awake workers: an executor ends while they are awake, and while its split changes") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  SyntheticWork work(800, 8.0f, 5);
  const std::uint64_t expected = hash(work.expected());
  const auto begin = Clock::now();
  for (int round = 0; round < 50; ++round) {
    ExecutorOptions options = awake(4, longest_awake);
    int broad = 1;
    options.balance.own_rule = [&](const ExecutionReport&) { return broad = broad % 3 + 1; };
    const auto executor = make_executor(options);
    for (int step = 0; step < round % 4; ++step) {
      ContactList contacts;
      ExecutionReport report;
      executor->run(work, contacts, report, {}, nullptr);
      CHECK(hash(contacts) == expected);
    }
  }
  CHECK(Clock::now() - begin < 50 * 100ms);  // none waited until its time was over
}

TEST_CASE("awake workers: an exception or a stop leaves them and the next step as they should be") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  SyntheticWork work(800, 8.0f, 5);
  const std::uint64_t expected = hash(work.expected());
  const auto executor = make_executor(awake(3, longest_awake));
  for (int step = 0; step < 12; ++step) {
    ContactList contacts;
    ExecutionReport report;
    std::stop_source stop;
    if (step % 4 == 1) stop.request_stop();
    work.on_pair = step % 4 == 2 ? [](Pair) { throw std::runtime_error("enough"); } : std::function<void(Pair)>();
    if (step % 4 == 2) {
      CHECK_THROWS_WITH(executor->run(work, contacts, report, stop.get_token(), nullptr), "enough");
      continue;
    }
    executor->run(work, contacts, report, stop.get_token(), nullptr);
    CHECK((step % 4 == 1 ? contacts.pairs.empty() : hash(contacts) == expected));
  }
}

TEST_CASE("awake workers: a host's limit of one thread leaves none awake, also if it comes while they are") {
  SyntheticWork work(800, 8.0f, 5);
  const std::uint64_t expected = hash(work.expected());
  std::optional<tbb::global_control> allow;
  allow.emplace(tbb::global_control::max_allowed_parallelism, 4);
  const auto executor = make_executor(awake(0, longest_awake));
  const auto run = [&] {
    ContactList contacts;
    ExecutionReport report;
    executor->run(work, contacts, report, {}, nullptr);
    CHECK(hash(contacts) == expected);
    return report;
  };
  for (int step = 0; step < 10; ++step) run();
  allow.emplace(tbb::global_control::max_allowed_parallelism, 1);
  run();
  // A worker that lost its core while awake ends, and is reported, some steps later.
  bool awake = true;
  for (int step = 0; step < 2000 && awake; ++step) {
    const ExecutionReport report = run();
    CHECK(report.threads == 1);
    awake = report.awake_ms > 0;
    if (awake) std::this_thread::sleep_for(5ms);
  }
  CHECK_FALSE(awake);
  allow.emplace(tbb::global_control::max_allowed_parallelism, 3);
  for (int step = 0; step < 10; ++step) run();
}

TEST_CASE("awake workers: several executors in one arena, and tasks of the host beside them") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  std::vector<std::unique_ptr<SyntheticWork>> works;
  std::vector<std::unique_ptr<Executor>> executors;
  for (unsigned i = 0; i < 4; ++i) {
    works.push_back(std::make_unique<SyntheticWork>(600, 8.0f, i));
    executors.push_back(make_executor(awake(2, 2000)));
  }
  std::atomic<int> right{0}, host{0};
  tbb::task_arena arena(3);
  for (int step = 0; step < 10; ++step)
    arena.execute([&] {
      tbb::parallel_for(0, 4, [&](int i) {
        const auto at = static_cast<std::size_t>(i);
        ContactList contacts;
        ExecutionReport report;
        executors[at]->run(*works[at], contacts, report, {}, nullptr);
        right += hash(contacts) == hash(works[at]->expected());
      });
      tbb::parallel_for(0, 100, [&](int) { ++host; });
    });
  CHECK(right == 40);
  CHECK(host == 1000);
}

TEST_CASE("awake workers: a time that cannot be is refused by its name") {
  using Catch::Matchers::StartsWith;
  for (const double wrong :
       {-1.0, 2e5, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (const ExecutorKind kind : executor_kinds)
      CHECK_THROWS_WITH(make_executor({.kind = kind, .stay_awake = wrong}), StartsWith("stay_awake: "));
}
