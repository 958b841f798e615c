// Executors over many steps with random options and failures.
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task_group.h>

#include <unistd.h>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <new>
#include <optional>
#include <random>

#include "catch.h"
#include "synthetic_work.h"
#include "tandem/flowgraph/report.h"

using namespace tandem;

namespace {

constexpr std::uint64_t default_steps = 1000;

/// The environment variable TANDEM_SOAK_STEPS.
std::uint64_t steps_asked_for() {
  const char* text = std::getenv("TANDEM_SOAK_STEPS");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : default_steps;
}

/// Resident memory in bytes; 0 if unknown.
double resident() {
  std::ifstream file("/proc/self/statm");
  double total = 0, pages = 0;
  file >> total >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE));
}

struct Counts {
  std::uint64_t right = 0, thrown = 0, stopped = 0, cancelled = 0, wrong = 0, not_empty = 0, resizes = 0, grown = 0;
};

/// Executors of every kind with random options over a few loads, each kept for many steps, under random limits, with
/// callbacks that throw, stops and cancellations.
class Soak {
 public:
  Soak() {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      works_.push_back(std::make_unique<SyntheticWork>(150 * seed, 5.0f, seed,
                                                       seed == 2 ? BroadPhaseKind::sweep : BroadPhaseKind::brute));
      works_.back()->is_heavy = [](Pair pair) { return pair.b % 50 == 3; };
      works_.back()->is_costliest = [](Pair pair) { return pair.b % 100 == 3; };
      expected_.push_back(hash(works_.back()->expected()));
    }
    executors_.resize(16);
  }

  void step() {
    auto& executor = executors_[pick(executors_.size())];
    if (!executor || pick(200) == 0) executor = make_executor(options());
    if (pick(50) == 0) {
      limit_.reset();
      limit_.emplace(tbb::global_control::max_allowed_parallelism, 1 + pick(most_threads_));
      ++counts.resizes;
    }
    const std::size_t which = pick(works_.size());
    SyntheticWork& work = *works_[which];
    const std::size_t event = pick(20);
    const std::uint32_t at = static_cast<std::uint32_t>(pick(work.bodies()));
    const auto fail = [] { throw std::runtime_error("on purpose"); };
    std::stop_source stop;
    tbb::task_group group;
    switch (event) {
      case 0:
        work.on_tile = [=](std::size_t tile) {
          if (tile == at % 3) fail();
        };
        break;
      case 1:
        work.on_pair = [=](Pair pair) {
          if (pair.a == at) fail();
        };
        break;
      case 2:
        work.on_keep = [=](std::span<Pair> pairs) {
          if (pairs[0].a >= at) fail();
          return pairs.size();
        };
        break;
      case 3:
        work.on_pair = [=](Pair pair) {
          if (pair.a == at) throw std::bad_alloc();
        };
        break;
      case 4:
        stop.request_stop();
        break;
      case 5:
        work.on_pair = [=, &stop](Pair pair) {
          if (pair.a == at) stop.request_stop();
        };
        break;
      case 6:
        work.on_pair = [=, &group](Pair pair) {
          if (pair.a == at) group.cancel();
        };
        break;
      default:
        break;
    }
    ContactList& contacts = contacts_;  // with the contents of the last step
    ExecutionReport report;
    bool thrown = false;
    const auto run = [&] {
      try {
        executor->run(work, contacts, report, stop.get_token(), nullptr);
      } catch (const std::exception&) {
        thrown = true;
      }
    };
    if (event == 6) {
      group.run(run);
      group.wait();
    } else {
      run();
    }
    work.on_tile = nullptr;
    work.on_pair = nullptr;
    work.on_keep = nullptr;

    counts.grown += (report.issues & bit(StepIssue::pool_grew)) != 0 ? 1 : 0;
    const bool early = (report.issues & bit(StepIssue::ended_early)) != 0;
    if (thrown || early) {
      ++(thrown ? counts.thrown : event == 6 ? counts.cancelled : counts.stopped);
      if (!contacts.pairs.empty() || !contacts.contacts.empty() || event > 6) ++counts.not_empty;
    } else {
      ++(hash(contacts) == expected_[which] ? counts.right : counts.wrong);
    }
  }

  Counts counts;

 private:
  std::size_t pick(std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_); }

  ExecutorOptions options() {
    ExecutorOptions options;
    options.kind = executor_kinds[pick(std::size(executor_kinds))];
    options.threads = static_cast<int>(1 + pick(most_threads_));
    if (options.threads > 1 && pick(2) == 0) {
      options.balance.split.broad = static_cast<int>(1 + pick(static_cast<std::size_t>(options.threads - 1)));
      options.balance.split.narrow = options.threads - options.balance.split.broad;
    }
    options.balance.strict = pick(3) == 0;
    if (!options.balance.strict)
      options.sharing.form = std::array{StepForm::automatic, StepForm::overlapped, StepForm::ordered}[pick(3)];
    options.balance.rule = pick(2) == 0 ? BalanceRule::paper : BalanceRule::busy;
    options.batches.pairs = std::size_t{1} << pick(9);
    options.batches.queue_capacity = pick(3) == 0 ? 1 + pick(4) : 0;
    options.sharing.short_step_ms = pick(5) == 0 ? 0.3 : 0;
    return options;
  }

  std::size_t most_threads_ = 4 * static_cast<std::size_t>(tbb::info::default_concurrency());
  std::mt19937_64 random_{20100};
  std::vector<std::unique_ptr<SyntheticWork>> works_;
  std::vector<std::uint64_t> expected_;
  std::optional<tbb::global_control> limit_{std::in_place, tbb::global_control::max_allowed_parallelism, most_threads_};
  std::vector<std::unique_ptr<Executor>> executors_;
  ContactList contacts_;
};

}  // namespace

TEST_CASE("soak: whatever is resized, thrown, stopped or cancelled, no pair is lost and no step hangs") {
  const std::uint64_t steps = steps_asked_for();
  Soak soak;
  double before = 0;
  for (std::uint64_t step = 0; step < steps; ++step) {
    if (step == steps / 4) before = resident();
    soak.step();
  }
  const double grown = resident() - before;
  const Counts& counts = soak.counts;
  if (steps != default_steps)
    std::cout << steps << " steps: " << counts.right << " right, " << counts.thrown << " ended by an exception, "
              << counts.stopped << " stopped, " << counts.cancelled << " cancelled, " << counts.wrong << " wrong; "
              << counts.resizes << " changes of the limit, the pool grew in " << counts.grown << "; resident memory "
              << 1e-6 * grown << " MB more than after a quarter\n";
  CHECK(counts.wrong == 0);
  CHECK(counts.not_empty == 0);
  CHECK(counts.right > steps / 2);
  CHECK(counts.thrown > steps / 50);
  CHECK(counts.stopped > steps / 100);
  CHECK(counts.cancelled > steps / 200);
  // Executors with other threads and loads are made and destroyed: their memory varies, but must not grow. The thread
  // sanitizer keeps a history of all accesses, which grows.
#if !defined(__SANITIZE_THREAD__)
  CHECK(grown < 64e6);
#endif
}
