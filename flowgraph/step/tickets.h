// The blocks of the stages of a step, and which of them is next.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "answers/thread_mark.h"
#include "step/pause.h"

namespace tandem {

/// The next block and stage, and the number of pending blocks: threads take blocks of the open stage until none
/// is left, and the thread that finishes the last one opens the next stage.
class Tickets {
 public:
  /// Begins a step of `stages` stages, none open; the last that is opened is `stages` itself, without blocks.
  void begin(std::size_t stages) {
    blocks_.assign(stages + 1, {});
    caller_.store(this_thread_mark(), std::memory_order_relaxed);
  }
  /// Opens a stage; by one thread at a time, which finished the stage before. `from_both_ends`: the thread that began
  /// the step takes the first half of the blocks, from the first on, the others the second half, from the last on, and
  /// then what is left of the other half. So in each stage and step a thread reads what it wrote itself: reading a
  /// cache line that another core wrote may take ten times as long.
  void open(std::size_t stage, std::size_t blocks, bool from_both_ends);

  std::size_t stage() const { return next_[0].load(std::memory_order_acquire) >> 32; }
  std::size_t blocks(std::size_t stage) const { return blocks_[stage].all; }
  /// True if no block of the stage is left to take.
  bool all_taken(std::size_t stage) const;
  /// Takes a block; false when the stage has none left or is not open.
  bool take(std::size_t stage, std::size_t& block);

  /// Adds one thing, such as a batch, that must be done before the open stage may end. The calling thread holds a block
  /// of it, or such a thing.
  void add() { left_.fetch_add(1, std::memory_order_relaxed); }
  /// Counts off a block, or a thing that was added: true for the last one.
  bool finish() { return left_.fetch_sub(1, std::memory_order_acq_rel) == 1; }

  /// Returns when the stage is over. Until then it calls help(), which returns whether it found something to do; spins
  /// for about as long as a short block lasts, then sleeps until a stage opens or wake() is called.
  template <class Help>
  void wait_while(std::size_t stage, Help&& help);
  void wake();

 private:
  struct Blocks {
    std::size_t all = 0, first_half = 0;  // `all` if they are taken from one end
  };

  /// Takes a block of the first half (0) or of the second (1).
  bool take_of(std::size_t half, std::size_t stage, std::size_t& block);

  std::vector<Blocks> blocks_;
  std::atomic<const void*> caller_{nullptr};
  // For each half the stage (high half of the word) and the number of blocks taken (low half): a block can only be
  // taken of the stage it belongs to.
  alignas(64) std::atomic<std::uint64_t> next_[2]{};
  alignas(64) std::atomic<std::size_t> left_{0};
  alignas(64) std::atomic<std::uint32_t> changes_{0};  // sleepers wait on it
};

template <class Help>
void Tickets::wait_while(std::size_t stage, Help&& help) {
  constexpr int spins = 1000;  // about 20 to 50 us: the time that a sleeping thread needs to wake
  for (int i = 0; i < spins; ++i) {
    if (this->stage() != stage) return;
    if (!help()) pause();
  }
  for (;;) {
    const std::uint32_t changes = changes_.load(std::memory_order_acquire);
    if (this->stage() != stage) return;
    if (!help()) changes_.wait(changes, std::memory_order_acquire);
  }
}

}  // namespace tandem
