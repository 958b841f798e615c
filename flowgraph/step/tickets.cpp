// Hands out the blocks of a step's stages to threads.
#include "step/tickets.h"

namespace tandem {

void Tickets::open(std::size_t stage, std::size_t blocks) {
  blocks_[stage] = blocks;
  left_.store(blocks, std::memory_order_relaxed);
  next_.store(std::uint64_t{stage} << 32, std::memory_order_release);
  wake();
}

bool Tickets::all_taken(std::size_t stage) const {
  const std::uint64_t next = next_.load(std::memory_order_acquire);
  return next >> 32 != stage || (next & 0xffffffffu) >= blocks_[stage];
}

bool Tickets::take(std::size_t stage, std::size_t& block) {
  std::uint64_t next = next_.load(std::memory_order_acquire);
  do {
    if (next >> 32 != stage) return false;
    block = next & 0xffffffffu;
    if (block >= blocks_[stage]) return false;
  } while (!next_.compare_exchange_weak(next, next + 1, std::memory_order_acquire));
  return true;
}

void Tickets::wake() {
  changes_.fetch_add(1, std::memory_order_release);
  changes_.notify_all();
}

}  // namespace tandem
