// All executors on synthetic work: answers, exceptions, stops, reports.
#include "tandem/flowgraph/executor.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include "catch.h"
#include "flowgraph/executors/batch_queue.h"
#include "flowgraph/step/step_state.h"
#include "synthetic_work.h"
#include "tandem/flowgraph/tile_work.h"

using namespace tandem;

namespace {

// A small machine limits oneTBB to its number of cores; without this the cases of more threads would test nothing new.
struct ManyThreads {
  tbb::global_control allow{tbb::global_control::max_allowed_parallelism, 16};
};

std::vector<Split> splits(int threads) {
  std::vector<Split> all{{}};
  if (threads > 1)
    for (int broad = 1; broad < threads; broad = broad == 1 && threads > 3 ? threads / 2
                                                 : threads == broad + 1    ? threads
                                                                           : threads - 1)
      all.push_back({broad, threads - broad});
  return all;
}

/// The variants of a step on several threads.
struct Variant {
  bool strict;
  StepForm form;
};
constexpr Variant variants[] = {
    {true, StepForm::overlapped}, {false, StepForm::overlapped}, {false, StepForm::ordered}};

std::vector<std::pair<ExecutorKind, StepForm>> kinds_and_forms() {
  std::vector<std::pair<ExecutorKind, StepForm>> all;
  for (const ExecutorKind kind : executor_kinds)
    for (const StepForm form : {StepForm::overlapped, StepForm::ordered}) all.emplace_back(kind, form);
  return all;
}

void check_equal(const ContactList& list, const ContactList& expected) {
  REQUIRE(list.pairs.size() == expected.pairs.size());
  REQUIRE(list.contacts.size() == expected.contacts.size());
  bool same = true;
  for (std::size_t i = 0; i < list.pairs.size(); ++i)
    same &= list.pairs[i].a == expected.pairs[i].a && list.pairs[i].b == expected.pairs[i].b &&
            list.pairs[i].first_contact == expected.pairs[i].first_contact &&
            list.pairs[i].contact_count == expected.pairs[i].contact_count;
  for (std::size_t i = 0; i < list.contacts.size(); ++i)
    same &= list.contacts[i].point == expected.contacts[i].point &&
            list.contacts[i].feature == expected.contacts[i].feature &&
            list.contacts[i].depth == expected.contacts[i].depth;
  CHECK(same);
  CHECK(hash(list) == hash(expected));
}

}  // namespace

TEST_CASE("every executor, thread count and split gives the answer of a double loop") {
  const ManyThreads many;
  for (const BroadPhaseKind broad : {BroadPhaseKind::brute, BroadPhaseKind::sweep})
    for (const std::size_t n : {0u, 1u, 2u, 300u, 3000u}) {
      SyntheticWork work(n, 12.0f, 5, broad);
      const ContactList expected = work.expected();
      if (n == 3000) REQUIRE(expected.pairs.size() > 5000);
      for (const ExecutorKind kind : executor_kinds)
        for (const int threads : {1, 2, 3, 8})
          for (const Split split : splits(threads))
            for (const bool strict : {false, true}) {
              if (strict && kind != ExecutorKind::flowgraph && kind != ExecutorKind::threads) continue;
              CAPTURE(name(broad), n, name(kind), threads, split.broad, split.narrow, strict);
              const auto executor = make_executor({.kind = kind,
                                                   .threads = threads,
                                                   .balance = {.split = split, .strict = strict},
                                                   .sharing = {.short_step_ms = 0}});
              for (int step = 0; step < 3; ++step) {
                ContactList contacts;
                ExecutionReport report;
                executor->run(work, contacts, report, {}, nullptr);
                check_equal(contacts, expected);
                CHECK(report.threads == (kind == ExecutorKind::sequential ? 1 : threads));
                if (n == 3000) CHECK(report.candidate_pairs > expected.pairs.size());
              }
            }
    }
}

TEST_CASE("a step without tiles leaves nothing of the last one's answer") {
  const ManyThreads many;
  SyntheticWork work(300, 8.0f, 5);
  const ContactList expected = work.expected();
  REQUIRE(expected.pairs.size() > 100);
  for (const auto& [kind, form] : kinds_and_forms())
    for (const int threads : {1, 3}) {
      CAPTURE(name(kind), threads, static_cast<int>(form));
      const auto executor =
          make_executor({.kind = kind, .threads = threads, .sharing = {.form = form, .short_step_ms = 0}});
      ContactList contacts;
      for (const bool no_tiles : {false, true, false, true}) {
        work.no_tiles = no_tiles;
        ExecutionReport report;
        executor->run(work, contacts, report, {}, nullptr);
        check_equal(contacts, no_tiles ? ContactList{} : expected);
      }
    }
}

TEST_CASE("batch size and queue capacity change nothing") {
  const ManyThreads many;
  SyntheticWork work(2000, 10.0f, 9);
  const ContactList expected = work.expected();
  for (const ExecutorKind kind : executor_kinds)
    for (const std::size_t batch : {1u, 7u, 128u, 65536u})
      for (const std::size_t capacity : {1u, 2u, 512u})
        for (const bool strict : {false, true}) {
          CAPTURE(name(kind), batch, capacity, strict);
          const auto executor = make_executor({.kind = kind,
                                               .threads = 4,
                                               .balance = {.strict = strict},
                                               .batches = {.pairs = batch, .queue_capacity = capacity},
                                               .sharing = {.short_step_ms = 0}});
          ContactList contacts;
          ExecutionReport report;
          executor->run(work, contacts, report, {}, nullptr);
          check_equal(contacts, expected);
        }
}

TEST_CASE("a writer hands on the costliest pairs one by one, other heavy ones in small batches, then the rest") {
  SyntheticWork work(2000, 10.0f, 9);
  const ContactList expected = work.expected();
  const auto is_heavy = [](Pair pair) { return pair.b % 5 == 0; };
  const auto is_costliest = [](Pair pair) { return pair.b % 20 == 0; };
  work.is_heavy = is_heavy;
  work.is_costliest = is_costliest;
  struct Shelf final : Delivery {
    void deliver(Batch& batch) override { batches.push_back(&batch); }
    std::vector<Batch*> batches;
  } shelf;
  StepState state;
  ContactList contacts;
  state.begin(work, contacts, {64, 3}, StepForm::overlapped, {}, nullptr);
  std::size_t costliest = 0, heavy = 0, light = 0;
  take_part(
      state, [](std::size_t) { return true; },
      [&] {
        BatchWriter writer(state, shelf);
        for (std::size_t tile; state.take(state.shared_stage(), tile);) state.run_tile(tile, writer);
        writer.flush();
        for (Batch* batch : shelf.batches) {
          const auto pairs = std::span<const Pair>(batch->pairs).first(batch->count);
          CHECK(std::all_of(pairs.begin(), pairs.end(), [&](Pair pair) {
            return is_heavy(pair) == batch->heavy && (is_heavy(pair) && is_costliest(pair)) == batch->costliest;
          }));
          CHECK(batch->count <= (batch->costliest ? 1 : batch->heavy ? 3 : 64));
          (batch->costliest ? costliest : batch->heavy ? heavy : light) += batch->count;
          state.process(*batch);
        }
      });
  ExecutionReport report;
  state.end(report);
  check_equal(contacts, expected);
  CHECK(costliest > 20);
  CHECK(heavy > costliest);
  CHECK(light > heavy);
  CHECK(report.heavy_pairs == costliest + heavy);
}

TEST_CASE("heavy pairs travel in batches of their own, each once") {
  const ManyThreads many;
  SyntheticWork work(2000, 10.0f, 9);
  const ContactList expected = work.expected();
  for (const unsigned every : {1u, 3u, 50u}) {
    work.is_heavy = [=](Pair pair) { return pair.b % every == 0; };
    work.is_costliest = [=](Pair pair) { return pair.b % (2 * every) == 0; };
    const auto heavy = [&](const PairResult& pair) { return pair.b % every == 0; };
    for (const ExecutorKind kind : executor_kinds)
      for (const std::size_t batch : {1u, 128u})
        for (const Variant variant : variants) {
          if (batch == 1 && variant.form == StepForm::ordered) continue;
          CAPTURE(every, name(kind), batch, variant.strict, name(variant.form));
          const auto executor = make_executor({.kind = kind,
                                               .threads = 3,
                                               .balance = {.strict = variant.strict},
                                               .batches = {.pairs = batch, .queue_capacity = 2},
                                               .sharing = {.form = variant.form, .short_step_ms = 0}});
          for (int step = 0; step < 3; ++step) {
            ContactList contacts;
            ExecutionReport report;
            executor->run(work, contacts, report, {}, nullptr);
            check_equal(contacts, expected);
            CHECK(report.heavy_pairs >=
                  static_cast<std::size_t>(std::count_if(expected.pairs.begin(), expected.pairs.end(), heavy)));
          }
        }
  }
}

TEST_CASE("a hundred runs with a moving balance have one hash") {
  const ManyThreads many;
  SyntheticWork work(1500, 9.0f, 2);
  const std::uint64_t expected = hash(work.expected());
  for (const ExecutorKind kind :
       {ExecutorKind::barrier, ExecutorKind::fused, ExecutorKind::threads, ExecutorKind::flowgraph})
    for (const BalanceRule rule : {BalanceRule::paper, BalanceRule::busy}) {
      CAPTURE(name(kind), name(rule));
      const auto executor =
          make_executor({.kind = kind, .threads = 6, .balance = {.rule = rule}, .sharing = {.short_step_ms = 0}});
      ContactList contacts;
      int different = 0;
      for (int run = 0; run < 100; ++run) {
        // The load changes sides every 20 steps, so that threads do move.
        work.on_tile = nullptr;
        work.on_pair = nullptr;
        if (run / 20 % 2 == 0)
          work.on_tile = [](std::size_t) { std::this_thread::sleep_for(std::chrono::microseconds(20)); };
        ExecutionReport report;
        executor->run(work, contacts, report, {}, nullptr);
        different += hash(contacts) != expected;
      }
      CHECK(different == 0);
    }
}

TEST_CASE("under a process limit of one thread every executor still ends") {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  SyntheticWork work(1500, 9.0f, 2);
  const ContactList expected = work.expected();
  for (const ExecutorKind kind : executor_kinds)
    for (const bool strict : {false, true}) {
      CAPTURE(name(kind), strict);
      const auto executor = make_executor({.kind = kind,
                                           .threads = 4,
                                           .balance = {.split = {2, 2}, .strict = strict},
                                           .batches = {.queue_capacity = 1},
                                           .sharing = {.short_step_ms = 0}});
      ContactList contacts;
      ExecutionReport report;
      executor->run(work, contacts, report, {}, nullptr);
      check_equal(contacts, expected);
    }
}

TEST_CASE("a limit that shrinks or grows between steps is followed") {
  SyntheticWork work(1500, 9.0f, 2);
  const ContactList expected = work.expected();
  const auto executor = make_executor(
      {.kind = ExecutorKind::flowgraph, .threads = 6, .balance = {.split = {4, 2}}, .sharing = {.short_step_ms = 0}});
  for (const std::size_t limit : {6u, 1u, 3u, 2u, 8u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, limit);
    const auto allowed =
        std::min<std::size_t>(6, tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
    ContactList contacts;
    ExecutionReport report;
    executor->run(work, contacts, report, {}, nullptr);
    check_equal(contacts, expected);
    CHECK(report.threads == static_cast<int>(allowed));
  }
}

TEST_CASE("inside a host's arena, from several of its tasks at once") {
  const ManyThreads many;
  tbb::task_arena host(4);
  std::atomic<int> wrong{0};
  host.execute([&] {
    tbb::parallel_for(0, 8, [&](int i) {
      SyntheticWork work(800, 7.0f, static_cast<unsigned>(i));
      const std::uint64_t expected = hash(work.expected());
      for (const ExecutorKind kind : executor_kinds) {
        const auto executor =
            make_executor({.kind = kind, .threads = i % 2 == 0 ? 3 : 0, .sharing = {.short_step_ms = 0}});
        for (int step = 0; step < 5; ++step) {
          ContactList contacts;
          ExecutionReport report;
          executor->run(work, contacts, report, {}, nullptr);
          wrong += hash(contacts) != expected;
        }
      }
    });
  });
  CHECK(wrong == 0);
}

TEST_CASE("what a callback throws ends the step, comes out once, and the next step is right") {
  const ManyThreads many;
  SyntheticWork work(2000, 10.0f, 9);
  const ContactList expected = work.expected();
  for (const ExecutorKind kind : executor_kinds)
    for (const int threads : {1, 2, 5})
      for (const Variant variant : variants)
        for (const int where : {0, 1, 2}) {
          CAPTURE(name(kind), threads, variant.strict, name(variant.form), where);
          const auto executor = make_executor({.kind = kind,
                                               .threads = threads,
                                               .balance = {.strict = variant.strict},
                                               .batches = {.pairs = 16, .queue_capacity = 2},
                                               .sharing = {.form = variant.form, .short_step_ms = 0}});
          for (int round = 0; round < 2; ++round) {
            if (where == 0)
              work.on_tile = [](std::size_t tile) {
                if (tile == 5) throw std::runtime_error("tile");
              };
            if (where == 1)
              work.on_pair = [](Pair pair) {
                if (pair.a % 100 == 7) throw std::runtime_error("pair");
              };
            if (where == 2) work.on_keep = [](std::span<Pair>) -> std::size_t { throw std::runtime_error("keep"); };
            ContactList contacts;
            ExecutionReport report;
            CHECK_THROWS_AS(executor->run(work, contacts, report, {}, nullptr), std::runtime_error);
            CHECK(contacts.pairs.empty());
            work.on_tile = nullptr;
            work.on_pair = nullptr;
            work.on_keep = nullptr;
            executor->run(work, contacts, report, {}, nullptr);
            check_equal(contacts, expected);
          }
        }
}

TEST_CASE("a requested stop ends the step early, with an empty answer") {
  const ManyThreads many;
  SyntheticWork work(2000, 10.0f, 9);
  const ContactList expected = work.expected();
  for (const auto& [kind, form] : kinds_and_forms()) {
    CAPTURE(name(kind), name(form));
    const auto executor = make_executor({.kind = kind, .threads = 3, .sharing = {.form = form, .short_step_ms = 0}});
    ContactList contacts;
    ExecutionReport report;
    std::stop_source before;
    before.request_stop();
    executor->run(work, contacts, report, before.get_token(), nullptr);
    CHECK(contacts.pairs.empty());
    std::stop_source within;
    work.on_tile = [&](std::size_t tile) {
      if (tile == 3) within.request_stop();
    };
    executor->run(work, contacts, report, within.get_token(), nullptr);
    CHECK(contacts.pairs.empty());
    work.on_tile = nullptr;
    executor->run(work, contacts, report, {}, nullptr);
    check_equal(contacts, expected);
  }
}

TEST_CASE("work within a batch is told that the step was stopped, cancelled or has failed") {
  const ManyThreads many;
  SyntheticWork work(500, 6.0f, 9);
  for (const auto& [kind, form] : kinds_and_forms())
    for (const bool by_error : {false, true}) {
      CAPTURE(name(kind), name(form), by_error);
      const auto executor = make_executor({.kind = kind, .threads = 3, .sharing = {.form = form, .short_step_ms = 0}});
      ContactList contacts;
      ExecutionReport report;
      std::stop_source within;
      std::atomic<int> asked{0}, early{0}, told{0};
      work.on_pair = [&](Pair) {
        if (asked.fetch_add(1) != 0) return;
        early += work.has_ended() ? 1 : 0;
        within.request_stop();
        told += work.has_ended() ? 1 : 0;
        if (by_error) throw std::runtime_error("in a pair");
      };
      if (by_error)
        CHECK_THROWS_AS(executor->run(work, contacts, report, within.get_token(), nullptr), std::runtime_error);
      else
        executor->run(work, contacts, report, within.get_token(), nullptr);
      CHECK(early == 0);
      CHECK(told == 1);
      CHECK(contacts.pairs.empty());
    }
}

TEST_CASE("a predicate that drops pairs is applied to each once") {
  const ManyThreads many;
  SyntheticWork work(2000, 10.0f, 9);
  const ContactList all = work.expected();
  work.on_keep = [](std::span<Pair> pairs) {
    return static_cast<std::size_t>(
        std::stable_partition(pairs.begin(), pairs.end(), [](Pair p) { return p.b % 2 == 0; }) - pairs.begin());
  };
  const auto kept = std::count_if(all.pairs.begin(), all.pairs.end(), [](const PairResult& p) { return p.b % 2 == 0; });
  for (const auto& [kind, form] : kinds_and_forms()) {
    const auto executor = make_executor(
        {.kind = kind, .threads = 3, .batches = {.pairs = 10}, .sharing = {.form = form, .short_step_ms = 0}});
    ContactList contacts;
    ExecutionReport report;
    executor->run(work, contacts, report, {}, nullptr);
    CHECK(contacts.pairs.size() == static_cast<std::size_t>(kept));
    work.on_keep = [](std::span<Pair>) { return std::size_t{0}; };
    executor->run(work, contacts, report, {}, nullptr);
    CHECK(contacts.pairs.empty());
    work.on_keep = [](std::span<Pair> pairs) {
      return static_cast<std::size_t>(
          std::stable_partition(pairs.begin(), pairs.end(), [](Pair p) { return p.b % 2 == 0; }) - pairs.begin());
    };
  }
}

TEST_CASE("a predicate that uses oneTBB itself neither hangs nor re-enters a tile") {
  const ManyThreads many;
  SyntheticWork work(2500, 10.0f, 9);
  const ContactList expected = work.expected();
  std::atomic<int> inner{0}, calls{0};
  work.on_keep = [&](std::span<Pair> pairs) {
    if (calls.fetch_add(1) % 8 != 0) return pairs.size();
    // Long enough that the waiting thread looks for other tasks.
    tbb::parallel_for(0, 8, [&](int) {
      std::this_thread::sleep_for(std::chrono::microseconds(50));
      inner.fetch_add(1);
    });
    return pairs.size();
  };
  for (const ExecutorKind kind : executor_kinds)
    for (const int threads : {2, 4, 16})
      for (const bool strict : {false, true}) {
        CAPTURE(name(kind), threads, strict);
        const auto executor = make_executor({.kind = kind,
                                             .threads = threads,
                                             .balance = {.strict = strict},
                                             .batches = {.pairs = 256},
                                             .sharing = {.short_step_ms = 0}});
        for (int step = 0; step < 5; ++step) {
          ContactList contacts;
          ExecutionReport report;
          executor->run(work, contacts, report, {}, nullptr);
          check_equal(contacts, expected);
        }
      }
  CHECK(inner > 500);
}

TEST_CASE("the host's cancellation ends a step early, with an empty answer") {
  const ManyThreads many;
  SyntheticWork work(2000, 10.0f, 9);
  for (const auto& [kind, form] : kinds_and_forms()) {
    if (kind == ExecutorKind::sequential || kind == ExecutorKind::threads) continue;
    CAPTURE(name(kind), name(form));
    const auto executor = make_executor({.kind = kind, .threads = 3, .sharing = {.form = form, .short_step_ms = 0}});
    ContactList contacts;
    tbb::task_group group;
    work.on_tile = [&](std::size_t tile) {
      if (tile == 3) group.cancel();
    };
    group.run([&] {
      ExecutionReport report;
      executor->run(work, contacts, report, {}, nullptr);
    });
    group.wait();
    CHECK(contacts.pairs.empty());
    work.on_tile = nullptr;
    ExecutionReport report;
    executor->run(work, contacts, report, {}, nullptr);
    check_equal(contacts, work.expected());
  }
}

TEST_CASE("a small step stays on the caller and says so") {
  const ManyThreads many;
  SyntheticWork work(20, 3.0f, 1);
  for (const ExecutorKind kind :
       {ExecutorKind::barrier, ExecutorKind::fused, ExecutorKind::threads, ExecutorKind::flowgraph}) {
    const auto executor = make_executor({.kind = kind, .threads = 2, .sharing = {.short_step_ms = 1000}});
    ContactList contacts;
    ExecutionReport first, second;
    executor->run(work, contacts, first, {}, nullptr);
    executor->run(work, contacts, second, {}, nullptr);
    CHECK((first.issues & bit(StepIssue::ran_on_caller)) == 0);
    CHECK((second.issues & bit(StepIssue::ran_on_caller)) != 0);
    check_equal(contacts, work.expected());
  }
}

TEST_CASE("on the caller alone batches are as large as they may be, whatever a pair costs") {
  const ManyThreads many;
  SyntheticWork work(400, 6.0f, 5);
  work.on_pair = [](Pair) {  // fewer than 64 would make a batch to hand on
    for (const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(2);
         std::chrono::steady_clock::now() < end;) {
    }
  };
  for (const ExecutorKind kind : executor_kinds) {
    CAPTURE(name(kind));
    const auto executor =
        make_executor({.kind = kind, .threads = 2, .batches = {.pairs = 64}, .sharing = {.short_step_ms = 1000}});
    ContactList contacts;
    ExecutionReport report;
    for (int i = 0; i < 3; ++i) {
      report = {};
      executor->run(work, contacts, report, {}, nullptr);
    }
    REQUIRE(report.form == StepForm::caller);
    CHECK(report.batches == (report.candidate_pairs + 63) / 64);
  }
}

TEST_CASE("what one thread does while no other can take a part is told by phase") {
  /// Sleeps: 1 ms before the first stage, 4 x 1 ms in stage 0, 2 ms in the one block of stage 1.
  class Sleeper final : public StepWork {
   public:
    std::size_t begin() override {
      sleep(1);
      return 3;
    }
    std::size_t blocks(std::size_t stage) const override { return stage == 1 ? 1 : 4; }
    void run(std::size_t stage, std::size_t) override { sleep(stage == 0 ? 1 : 2); }
    void emit(std::size_t tile, PairSink& sink) override { sink.put(0, static_cast<std::uint32_t>(tile + 1)); }
    const PairFilter& filter() const override { return filter_; }
    std::size_t keep(std::span<Pair> pairs) const override { return pairs.size(); }
    HeavyPairs heavy_first(std::span<Pair>, std::chrono::nanoseconds) const override { return {}; }
    void narrow(Batch&) const override {}
    std::size_t bodies() const override { return 5; }

   private:
    static void sleep(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }
    PairFilter filter_;
  } work;
  for (const ExecutorKind kind : {ExecutorKind::barrier, ExecutorKind::threads, ExecutorKind::flowgraph})
    for (const StepForm form : {StepForm::overlapped, StepForm::ordered, StepForm::caller}) {
      CAPTURE(name(kind), name(form));
      const auto executor = make_executor({.kind = kind, .threads = 2, .sharing = {.form = form, .short_step_ms = 0}});
      double update = 1e300, join = 1e300;  // the minimum, since a thread may be held up while it opens a stage
      // On a busy machine more steps may pass until none is held up.
      for (int step = 0; step < 5 || (step < 500 && form != StepForm::caller && (update >= 1 || join >= 1)); ++step) {
        ContactList contacts;
        ExecutionReport report;
        executor->run(work, contacts, report, {}, nullptr);
        CHECK(report.busy_ms >= 7);
        if (form == StepForm::caller) {
          CHECK(report.serial.sum() == 0);
          continue;
        }
        CHECK(report.serial.begin >= 1);
        CHECK(report.serial.broad >= 2);
        CHECK(report.serial.sum() <= report.busy_ms);
        update = std::min(update, report.serial.update);
        join = std::min(join, report.serial.join);
      }
      if (form == StepForm::caller) continue;
      CHECK(update < 1);
      CHECK(join < 1);
      CHECK(join > 0);
    }
}

TEST_CASE("parts of one batch are shared with threads that have nothing to do, each run once") {
  /// One tile with one pair, whose parts wait until a second thread has come.
  class OnePair final : public StepWork {
   public:
    void work_with(Crew* crew) override { crew_ = crew; }
    std::size_t begin() override { return 2; }
    std::size_t blocks(std::size_t) const override { return 1; }
    void run(std::size_t, std::size_t) override {}
    void emit(std::size_t, PairSink& sink) override { sink.put(0, 1); }
    const PairFilter& filter() const override { return filter_; }
    std::size_t keep(std::span<Pair> pairs) const override { return pairs.size(); }
    void narrow(Batch& batch) const override {
      if (batch.count == 0 || crew_ == nullptr) return;
      crew_->share(50, [&](std::size_t part) {
        ++runs[part];
        if (part == fails_at) throw std::runtime_error("part");
        if (!waits) return;
        std::unique_lock lock(mutex_);
        threads.insert(std::this_thread::get_id());
        changed_.notify_all();
        changed_.wait_for(lock, std::chrono::seconds(20), [&] { return threads.size() > 1; });
      });
    }
    std::size_t bodies() const override { return 2; }

    mutable std::array<std::atomic<int>, 50> runs{};
    mutable std::set<std::thread::id> threads;
    std::size_t fails_at = 1000;
    bool waits = true;

   private:
    Crew* crew_ = nullptr;
    PairFilter filter_;
    mutable std::mutex mutex_;
    mutable std::condition_variable changed_;
  };
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  for (const ExecutorKind kind : {ExecutorKind::threads, ExecutorKind::flowgraph})
    for (const StepForm form : {StepForm::overlapped, StepForm::ordered}) {
      CAPTURE(name(kind), name(form));
      OnePair work;
      const auto executor = make_executor({.kind = kind, .threads = 2, .sharing = {.form = form, .short_step_ms = 0}});
      const auto step = [&] {
        ContactList contacts;
        ExecutionReport report;
        executor->run(work, contacts, report, {}, nullptr);
      };
      step();
      CHECK(work.threads.size() == 2);
      CHECK(std::all_of(work.runs.begin(), work.runs.end(), [](const auto& runs) { return runs == 1; }));
      work.waits = false;
      work.fails_at = 7;
      CHECK_THROWS_AS(step(), std::runtime_error);
      work.fails_at = 1000;
      step();
    }
}

TEST_CASE("threads without work of their own phase go on with the other's, unless the split is strict") {
  const ManyThreads many;
  SyntheticWork work(2000, 10.0f, 9);
  std::mutex mutex;
  std::set<std::thread::id> at_tiles, at_pairs;
  const auto note = [&](std::set<std::thread::id>& threads) {
    const std::scoped_lock lock(mutex);
    threads.insert(std::this_thread::get_id());
  };
  const auto sleep = [] { std::this_thread::sleep_for(std::chrono::milliseconds(2)); };
  for (const bool broad_is_long : {true, false})
    for (const bool strict : {false, true}) {
      CAPTURE(broad_is_long, strict);
      std::size_t most = 0;
      work.on_tile = [&](std::size_t) {
        note(at_tiles);
        if (broad_is_long) sleep();
      };
      work.on_pair = [&](Pair pair) {
        note(at_pairs);
        if (!broad_is_long && pair.b % 32 == 0) sleep();
      };
      const auto executor = make_executor({.kind = ExecutorKind::flowgraph,
                                           .threads = 4,
                                           .balance = {.split = {2, 2}, .strict = strict},
                                           .batches = {.pairs = 32},
                                           .sharing = {.form = StepForm::overlapped, .short_step_ms = 0}});
      // On a busy machine a worker may come too late for some steps.
      for (int step = 0; step < 3 || (step < 500 && !strict && most <= 2); ++step) {
        at_tiles.clear();
        at_pairs.clear();
        ContactList contacts;
        ExecutionReport report;
        executor->run(work, contacts, report, {}, nullptr);
        most = std::max(most, (broad_is_long ? at_tiles : at_pairs).size());
        if (strict) CHECK(at_tiles.size() <= 2);
      }
      if (!strict) CHECK(most > 2);
    }
}

TEST_CASE("the queue between the phases is bounded, and gives away the costliest batches first") {
  BatchQueue queue;
  queue.set_capacity(2);
  Batch light, heavy, costliest, more, too_many;
  heavy.heavy = true;
  costliest.heavy = costliest.costliest = true;
  CHECK(queue.try_push(light));
  CHECK(queue.try_push(heavy));
  CHECK(queue.try_push(costliest));
  CHECK(queue.try_push(more));
  CHECK(!queue.try_push(too_many));
  CHECK(queue.size() == 4);
  for (const Batch* expected : {&costliest, &heavy, &light, &more}) {
    Batch* batch = nullptr;
    CHECK(queue.try_pop(batch));
    CHECK(batch == expected);
  }
  Batch* none = nullptr;
  CHECK(!queue.try_pop(none));
}

TEST_CASE("bad executor options are refused with what was found and what is allowed") {
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(make_executor({.threads = -1}), Contains("threads: -1") && Contains("1024"));
  CHECK_THROWS_WITH(make_executor({.threads = 4096}), Contains("threads: 4096"));
  CHECK_THROWS_WITH(make_executor({.threads = 4, .balance = {.split = {1, 2}}}),
                    Contains("balance.split: 1-2") && Contains("4"));
  CHECK_THROWS_WITH(make_executor({.threads = 4, .balance = {.split = {4, 0}}}), Contains("balance.split: 4-0"));
  constexpr int most = std::numeric_limits<int>::max();
  for (const Split split : {Split{most, most}, Split{most, 1}, Split{1000, 25}})
    CHECK_THROWS_WITH(make_executor({.balance = {.split = split}}), Contains("at most 1024 threads in all"));
  CHECK_THROWS_WITH(make_executor({.batches = {.pairs = 0}}), Contains("batches.pairs: 0"));
  CHECK_THROWS_WITH(make_executor({.stay_awake = 1e5 + 1e-9}), Contains("stay_awake: 100000.000000001"));
  CHECK_THROWS_WITH(make_executor({.sharing = {.short_step_ms = -1e308}}), Contains("-1e+308"));
  CHECK_THROWS_WITH(make_executor({.sharing = {.short_step_ms = -1}}), Contains("sharing.short_step_ms"));
}

TEST_CASE("made-up work: times that are none or endless, and more bodies than there are names, are refused by name") {
  const TileWork::Size good{.tiles = 2, .pairs_a_tile = 3, .tile_ns = 10, .pair_ns = 10};
  TileWork work(good);
  work.set_costs(0, TileWork::longest_ns);
  const auto refused = [](TileWork::Size size) { CHECK_THROWS_AS(TileWork(size), std::invalid_argument); };
  for (const double ns : {-1.0, 1e300, 1.1e12, std::nan(""), std::numeric_limits<double>::infinity()}) {
    TileWork::Size tile = good, pair = good, big = good;
    tile.tile_ns = pair.pair_ns = big.big_ns = ns;
    refused(tile), refused(pair), refused(big);
    CHECK_THROWS_WITH(work.set_costs(ns, 1), Catch::StartsWith("tile_work: tile_ns is "));
    CHECK_THROWS_WITH(work.set_costs(1, ns), Catch::EndsWith(", allowed: 0 to 1000000000000 ns"));
  }
  refused({.tiles = std::size_t{1} << 32});
  refused({.tiles = 1, .pairs_a_tile = SIZE_MAX});
}
