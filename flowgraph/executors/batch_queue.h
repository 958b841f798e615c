// A bounded queue of batches.
#pragma once
#include <oneapi/tbb/concurrent_queue.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <mutex>

#include "tandem/flowgraph/batch.h"

namespace tandem {

/// Capacity of the queue. A producer that finds the queue full narrows a batch itself while its tile waits: with more
/// threads, more of them may do that at once and leave the costly pairs of their tiles for the end.
inline std::size_t usual_queue_capacity(int threads) {
  const auto count = static_cast<std::size_t>(threads);
  return std::clamp(4 * count * count, std::size_t{16}, std::size_t{1} << 20);
}

/// The bounded queue of batches between the phases. The costliest batches leave first, then other heavy ones, then the
/// rest.
class BatchQueue {
 public:
  /// Sets how many batches of each kind the queue holds at most. Not while threads use it.
  void set_capacity(std::size_t batches) {
    for (Queue& queue : queues_) queue.set_capacity(static_cast<std::ptrdiff_t>(batches));
  }

  /// Puts a batch; false if the queue is full.
  bool try_push(Batch& batch) {
#if TBB_INTERFACE_VERSION < 12090 && !defined(__x86_64__)
    // Before oneTBB 2021.9 a push reads what the push before it wrote without memory ordering between the two: on
    // processors that reorder such accesses (ARM), batches are lost.
    const std::scoped_lock one_at_a_time(pushing_);
#endif
    return queues_[batch.costliest ? 0 : batch.heavy ? 1 : 2].try_push(&batch);
  }
  /// Takes a batch; false if the queue is empty.
  bool try_pop(Batch*& batch) {
    return std::any_of(queues_.begin(), queues_.end(), [&](Queue& queue) { return queue.try_pop(batch); });
  }

  /// The number of batches waiting, approximately: other threads push and pop meanwhile.
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
