#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

namespace tandem {

/// Stages of blocks within one stage of a broad phase: whoever needs their end helps, and waits for what others have
/// begun. So those who can do without may go on meanwhile, and the pairs that they find leave at once.
class JointStages {
 public:
  /// Before a step, by one thread: `blocks` of stage 0, at least 1.
  void start(std::size_t stages, std::size_t blocks) {
    blocks_.assign(stages, 0);
    blocks_[0] = blocks;
    done_.store(0, std::memory_order_relaxed);
    failed_.store(false, std::memory_order_relaxed);
    ticket_.store(0, std::memory_order_release);
  }

  /// Returns when all stages are done, and whether they are: not when a block threw, here or elsewhere. run(stage,
  /// block) runs a block, blocks(stage) is asked for by one thread when the stages before are done; neither may wait.
  template <class Blocks, class Run>
  bool join(const Blocks& blocks, const Run& run) {
    for (;;) {
      std::uint64_t ticket = ticket_.load(std::memory_order_acquire);
      const std::size_t stage = ticket >> 32, block = ticket & 0xffffffffu;
      if (stage == blocks_.size()) return !failed_.load(std::memory_order_relaxed);
      if (block >= blocks_[stage]) {
        std::this_thread::yield();
        continue;
      }
      if (!ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_acquire)) continue;
      // Who waits must not wait for ever when memory is out.
      struct Done {
        JointStages& stages;
        const Blocks& blocks;
        std::size_t stage;
        bool ran = false;
        ~Done() { stages.finish(stage, ran, blocks); }
      } done{*this, blocks, stage};
      if (!failed_.load(std::memory_order_relaxed)) run(stage, block);
      done.ran = true;
    }
  }

 private:
  template <class Blocks>
  void finish(std::size_t stage, bool ran, const Blocks& blocks) {
    if (!ran) failed_.store(true, std::memory_order_relaxed);
    if (done_.fetch_add(1, std::memory_order_acq_rel) + 1 != blocks_[stage]) return;
    done_.store(0, std::memory_order_relaxed);
    const bool failed = failed_.load(std::memory_order_relaxed);
    do {
      if (++stage == blocks_.size()) break;
      blocks_[stage] = failed ? 0 : blocks(stage);
    } while (blocks_[stage] == 0);
    ticket_.store(std::uint64_t{stage} << 32, std::memory_order_release);
  }

  // Stage in the high half, next block in the low half: a block can only be taken of the stage it belongs to.
  alignas(64) std::atomic<std::uint64_t> ticket_{0};
  alignas(64) std::atomic<std::size_t> done_{0};
  std::atomic<bool> failed_{false};
  std::vector<std::size_t> blocks_;  // of each stage that was reached
};

}  // namespace tandem
