// Parallel loops whose result does not depend on the threads.
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

/// Runs body(begin, end) on blocks of [0, n), in the calling thread's arena and isolated from its other tasks; in order
/// on the caller if there is a single block or the arena has no other thread. Blocks must be independent, so that the
/// result does not depend on the threads. `time` adds up loops of several blocks.
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
    // Isolated: cancellation of the caller's context would leave bodies half moved.
    tbb::task_group_context context(tbb::task_group_context::isolated);
    tbb::this_task_arena::isolate(
        [&] { tbb::parallel_for(std::size_t{0}, blocks, run, tbb::simple_partitioner(), context); });
  }
  time.sum += std::chrono::steady_clock::now() - start;
}

}  // namespace tandem
