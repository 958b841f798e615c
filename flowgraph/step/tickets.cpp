// Hands out the blocks of a step's stages to threads.
#include "step/tickets.h"

namespace tandem {

void Tickets::open(std::size_t stage, std::size_t blocks, bool from_both_ends) {
  blocks_[stage] = blocks;
  both_ends_.store(from_both_ends, std::memory_order_relaxed);
  left_.store(blocks, std::memory_order_relaxed);
  next_.store(std::uint64_t{stage} << stage_at, std::memory_order_release);
  wake();
}

bool Tickets::all_taken(std::size_t stage) const {
  const std::uint64_t next = next_.load(std::memory_order_acquire);
  return next >> stage_at != stage || (next >> first_at & mask) + (next & mask) >= blocks_[stage];
}

bool Tickets::take(std::size_t stage, std::size_t& block) {
  std::uint64_t next = next_.load(std::memory_order_acquire);
  const bool first =
      !both_ends_.load(std::memory_order_relaxed) || this_thread_mark() == caller_.load(std::memory_order_relaxed);
  const std::uint64_t one = std::uint64_t{1} << (first ? first_at : 0);
  do {
    if (next >> stage_at != stage) return false;
    const std::size_t begin = next >> first_at & mask, end = blocks_[stage] - (next & mask);
    if (begin >= end) return false;
    block = first ? begin : end - 1;
  } while (!next_.compare_exchange_weak(next, next + one, std::memory_order_acquire));
  return true;
}

void Tickets::wake() {
  changes_.fetch_add(1, std::memory_order_release);
  changes_.notify_all();
}

}  // namespace tandem
