#pragma once
#include <oneapi/tbb/concurrent_queue.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <mutex>

#include "tandem/flowgraph/batch.h"

namespace tandem {

/// Batches that may wait. A producer that finds the queue full narrows a batch, and the tile in its hand waits: the
/// more threads there are, the more of them may do that at once and leave the costly pairs of their tiles for the end.
inline std::size_t usual_queue_capacity(int threads) {
  const auto count = static_cast<std::size_t>(threads);
  return std::clamp(4 * count * count, std::size_t{16}, std::size_t{1} << 20);
}

/// The bounded queue between the phases. The costliest batches leave first, then other heavy ones, then the rest.
class BatchQueue {
 public:
  /// How many batches of each kind it holds at most. Not while threads use it.
  void set_capacity(std::size_t batches) {
    for (Queue& queue : queues_) queue.set_capacity(static_cast<std::ptrdiff_t>(batches));
  }

  /// False if it is full.
  bool try_push(Batch& batch) {
#if TBB_INTERFACE_VERSION < 12090 && !defined(__x86_64__)
    // Before 2021.9 a push reads what the push before it wrote without an order between the two: where the processor
    // has none of its own, batches are lost.
    const std::scoped_lock one_at_a_time(pushing_);
#endif
    return queues_[batch.costliest ? 0 : batch.heavy ? 1 : 2].try_push(&batch);
  }
  /// False if it is empty.
  bool try_pop(Batch*& batch) {
    return std::any_of(queues_.begin(), queues_.end(), [&](Queue& queue) { return queue.try_pop(batch); });
  }

  /// Batches that wait, about: other threads push and pop while they are counted.
  std::size_t size() const {
    std::ptrdiff_t sum = 0;
    for (const Queue& queue : queues_) sum += std::clamp<std::ptrdiff_t>(queue.size(), 0, queue.capacity());
    return static_cast<std::size_t>(sum);
  }

 private:
  using Queue = tbb::concurrent_bounded_queue<Batch*>;
  std::array<Queue, 3> queues_;
#if TBB_INTERFACE_VERSION < 12090 && !defined(__x86_64__)
  std::mutex pushing_;
#endif
};

}  // namespace tandem
