#pragma once
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cstddef>

namespace tandem {

/// Wall time of the loops that threads may share.
struct ParallelTime {
  std::chrono::steady_clock::duration sum{};
};

/// Runs body(begin, end) for blocks of [0, n), in the calling thread's arena and apart from its other tasks; in the
/// blocks' order on the caller when there is one block only or the arena has no other thread. Blocks must not depend
/// on each other: then the answer does not depend on who runs them. `time` counts loops of several blocks.
template <class Body>
void for_blocks(std::size_t n, std::size_t block, ParallelTime& time, const Body& body) {
  const std::size_t blocks = (n + block - 1) / block;
  const auto run = [&](std::size_t i) { body(i * block, std::min(n, (i + 1) * block)); };
  if (blocks <= 1) {
    if (blocks == 1) run(0);
    return;
  }
  const auto start = std::chrono::steady_clock::now();
  if (tbb::this_task_arena::max_concurrency() == 1) {
    for (std::size_t i = 0; i < blocks; ++i) run(i);
  } else {
    // Not bound to the caller's context: its cancellation would leave bodies half moved.
    tbb::task_group_context context(tbb::task_group_context::isolated);
    tbb::this_task_arena::isolate(
        [&] { tbb::parallel_for(std::size_t{0}, blocks, run, tbb::simple_partitioner(), context); });
  }
  time.sum += std::chrono::steady_clock::now() - start;
}

}  // namespace tandem
