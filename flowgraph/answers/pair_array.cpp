// The paper's shared array of pairs: segments of doubling size, filled and emptied without locks.
#include "answers/pair_array.h"

#include <algorithm>
#include <bit>
#include <thread>

namespace tandem {

PairArray::~PairArray() {
  for (auto& segment : segments_) delete[] segment.load();
}

namespace {

struct Place {
  std::size_t segment, size, offset;
};

// Segment k holds the indices [first (2^k - 1), first (2^(k+1) - 1)).
Place place(std::size_t index, std::size_t first) {
  const auto segment = static_cast<std::size_t>(std::bit_width(index / first + 1)) - 1;
  const std::size_t size = first << segment;
  return {segment, size, index - (size - first)};
}

}  // namespace

PairArray::Slot& PairArray::slot(std::size_t index) {
  const Place at = place(index, first_segment);
  Slot* slots = segments_[at.segment].load(std::memory_order_acquire);
  if (slots == nullptr) {
    auto fresh = std::make_unique<Slot[]>(at.size);
    if (segments_[at.segment].compare_exchange_strong(slots, fresh.get(), std::memory_order_acq_rel))
      slots = fresh.release();
  }
  return slots[at.offset];
}

PairArray::Slot* PairArray::existing(std::size_t index) const {
  const Place at = place(index, first_segment);
  Slot* slots = segments_[at.segment].load(std::memory_order_acquire);
  return slots == nullptr ? nullptr : slots + at.offset;
}

void PairArray::begin() {
  const std::size_t used = std::max(tail_.load(), head_.load());
  for (std::size_t i = 0; i < used; ++i)
    if (Slot* slot = existing(i)) slot->store(nullptr, std::memory_order_relaxed);
  tail_.store(0);
  head_.store(0);
  closed_.store(false);
}

void PairArray::put(Batch& batch) {
  std::size_t index = tail_.load(std::memory_order_relaxed);
  Slot* place = nullptr;
  do place = &slot(index);  // Makes the segment first, which may throw: an index that is taken is always filled.
  while (!tail_.compare_exchange_weak(index, index + 1, std::memory_order_relaxed));
  place->store(&batch, std::memory_order_release);
  changes_.fetch_add(1, std::memory_order_release);
  changes_.notify_all();
}

void PairArray::close() {
  closed_.store(true, std::memory_order_release);
  changes_.fetch_add(1, std::memory_order_release);
  changes_.notify_all();
}

Batch* PairArray::take() { return wait_for(head_.fetch_add(1, std::memory_order_relaxed)); }

Batch* PairArray::try_take() {
  std::size_t index = head_.load(std::memory_order_relaxed);
  do {
    if (index >= tail_.load(std::memory_order_relaxed)) return nullptr;
  } while (!head_.compare_exchange_weak(index, index + 1, std::memory_order_relaxed));
  return wait_for(index);  // Waits at most until the thread that is putting this batch has done so.
}

Batch* PairArray::wait_for(std::size_t index) {
  constexpr int spins = 200;
  for (int i = 0;; ++i) {
    const std::uint32_t changes = changes_.load(std::memory_order_acquire);
    // Read before the slot: all puts come before the close.
    const bool closed = closed_.load(std::memory_order_acquire);
    if (Slot* mine = existing(index))
      if (Batch* batch = mine->load(std::memory_order_acquire)) return batch;
    if (closed) return nullptr;
    if (i < spins)
      std::this_thread::yield();
    else
      changes_.wait(changes, std::memory_order_acquire);
  }
}

}  // namespace tandem
