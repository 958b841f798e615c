// Hands out the blocks of a step's stages to threads.
#include "step/tickets.h"

namespace tandem {

void Tickets::open(std::size_t stage, std::size_t blocks, bool from_both_ends) {
  blocks_[stage] = {blocks, from_both_ends ? blocks - blocks / 2 : blocks};
  left_.store(blocks, std::memory_order_relaxed);
  for (std::size_t half = 2; half-- > 0;) next_[half].store(std::uint64_t{stage} << 32, std::memory_order_release);
  wake();
}

bool Tickets::all_taken(std::size_t stage) const {
  std::size_t taken = 0;
  for (const auto& half : next_) {
    const std::uint64_t next = half.load(std::memory_order_acquire);
    if (next >> 32 != stage) return true;
    taken += next & 0xffffffffu;
  }
  return taken >= blocks_[stage].all;
}

bool Tickets::take_of(std::size_t half, std::size_t stage, std::size_t& block) {
  std::uint64_t next = next_[half].load(std::memory_order_acquire);
  do {
    if (next >> 32 != stage) return false;
    const Blocks& blocks = blocks_[stage];
    const std::size_t taken = next & 0xffffffffu;
    if (taken >= (half == 0 ? blocks.first_half : blocks.all - blocks.first_half)) return false;
    block = half == 0 ? taken : blocks.all - 1 - taken;
  } while (!next_[half].compare_exchange_weak(next, next + 1, std::memory_order_acquire));
  return true;
}

bool Tickets::take(std::size_t stage, std::size_t& block) {
  const std::size_t own = this_thread_mark() == caller_.load(std::memory_order_relaxed) ? 0 : 1;
  return take_of(own, stage, block) || take_of(1 - own, stage, block);
}

void Tickets::wake() {
  changes_.fetch_add(1, std::memory_order_release);
  changes_.notify_all();
}

}  // namespace tandem
