// Measures the costs of this machine's threads, tasks and queues for the simulator of executors.
#include "machine_costs.h"

#include <oneapi/tbb/concurrent_queue.h>
#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include "clocks.h"
#include "tandem/flowgraph/executor.h"
#include "tandem/flowgraph/tile_work.h"

namespace tandem::bench {
namespace {

using Clock = std::chrono::steady_clock;

double ns_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
}

bool wait_until(const std::atomic<bool>& flag) {
  const auto give_up = Clock::now() + std::chrono::seconds(1);
  while (!flag.load(std::memory_order_acquire))
    if (Clock::now() > give_up) return false;
  return true;
}

/// The cost of an empty tile of a step on one thread.
void measure_task(Samples& out) {
  constexpr std::size_t tiles = 20'000;
  TileWork work({.tiles = tiles});
  const auto executor = make_executor({.kind = ExecutorKind::sequential});
  for (int i = 0; i < 30; ++i) {
    ContactList contacts;
    ExecutionReport report;
    executor->run(work, contacts, report, {}, nullptr);
    out.add(1e6 * report.narrow_end_ms / tiles);
  }
}

/// The cost of a message through the queue from one thread to another.
void measure_message(Samples& out) {
  constexpr int messages = 20'000;
  for (int i = 0; i < 10; ++i) {
    tbb::concurrent_bounded_queue<int*> queue;
    queue.set_capacity(64);
    int thing = 0;
    std::jthread consumer([&] {
      int* taken = nullptr;
      for (int k = 0; k < messages; ++k)
        while (!queue.try_pop(taken)) std::this_thread::yield();
    });
    const auto begin = Clock::now();
    for (int k = 0; k < messages; ++k)
      while (!queue.try_push(&thing)) std::this_thread::yield();
    consumer.join();
    out.add(ns_since(begin) / messages);
  }
}

/// The cost of passing a cache line from one spinning thread to another.
void measure_hand_over(Samples& out) {
  constexpr int rounds = 2000;
  for (int i = 0; i < 20; ++i) {
    std::atomic<int> turn{0};
    std::jthread other([&] {
      for (int k = 0; k < rounds; ++k) {
        while (turn.load(std::memory_order_acquire) != 2 * k + 1) std::this_thread::yield();
        turn.store(2 * k + 2, std::memory_order_release);
      }
    });
    const auto begin = Clock::now();
    for (int k = 0; k < rounds; ++k) {
      turn.store(2 * k + 1, std::memory_order_release);
      while (turn.load(std::memory_order_acquire) != 2 * k + 2) std::this_thread::yield();
    }
    out.add(ns_since(begin) / (2 * rounds));
  }
}

/// An arena of a phase as the executor makes it, with room for one worker, and in it a graph of one node.
class Node {
 public:
  Node() : arena_(2, 1) {
    arena_.execute([this] {
      graph_.emplace();
      node_.emplace(*graph_, tbb::flow::unlimited, [this](int) {
        arrived_ = Clock::now();
        flag_.store(true, std::memory_order_release);
        return tbb::flow::continue_msg();
      });
    });
  }
  void put() {
    flag_.store(false, std::memory_order_relaxed);
    node_->try_put(0);
  }
  /// The time from `begin` to the worker's first instruction; nothing if none came.
  std::optional<double> arrival(Clock::time_point begin) {
    const bool came = wait_until(flag_);
    arena_.execute([this] { graph_->wait_for_all(); });
    return came ? std::optional(std::chrono::duration<double, std::nano>(arrived_ - begin).count()) : std::nullopt;
  }
  void recreate() {
    arena_.terminate();
    arena_.initialize(2, 1);
    arena_.execute([this] { graph_->reset(); });
  }

 private:
  tbb::task_arena arena_;
  std::optional<tbb::flow::graph> graph_;
  std::optional<tbb::flow::function_node<int>> node_;
  std::atomic<bool> flag_{false};
  Clock::time_point arrived_;
};

void measure_wake(Samples& out) {
  Node node;
  for (int i = 0; i < 200; ++i) {
    stay_busy(std::chrono::microseconds(1500));  // as a simulation does between two steps
    const auto begin = Clock::now();
    node.put();
    if (const auto ns = node.arrival(begin)) out.add(*ns);
  }
}

/// The time to make both arenas anew right after a worker was active in one of them, then until its first task in the
/// new one.
void measure_resize(Samples& resize, Samples& move) {
  Node broad, narrow;
  for (int i = 0; i < 200; ++i) {
    auto begin = Clock::now();
    broad.put();
    if (!broad.arrival(begin)) continue;
    begin = Clock::now();
    broad.recreate();
    narrow.recreate();
    resize.add(ns_since(begin));
    begin = Clock::now();
    narrow.put();
    if (const auto ns = narrow.arrival(begin)) move.add(*ns);
  }
}

}  // namespace

MachineCosts CostSamples::costs() const {
  return {.task = task.median(),
          .message = message.median(),
          .wake = wake.median(),
          .resize = resize.median(),
          .move = move.median(),
          .hand_over = hand_over.median()};
}

CostSamples measure_costs() {
  CostSamples all;
  measure_task(all.task);
  if (std::thread::hardware_concurrency() < 2) return all;
  measure_message(all.message);
  measure_hand_over(all.hand_over);
  measure_wake(all.wake);
  measure_resize(all.resize, all.move);
  return all;
}

MachineCosts least(const MachineCosts& a, const MachineCosts& b) {
  MachineCosts both = a;
  for (double MachineCosts::*cost : {&MachineCosts::task, &MachineCosts::message, &MachineCosts::wake,
                                     &MachineCosts::resize, &MachineCosts::move, &MachineCosts::hand_over})
    both.*cost = std::min(a.*cost, b.*cost);
  return both;
}

}  // namespace tandem::bench
