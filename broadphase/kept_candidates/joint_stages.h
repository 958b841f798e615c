#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

namespace tandem {

/// Stages of blocks within one stage of a broad phase: whoever needs their end helps, and waits for what others have
/// begun. So those who can do without may go on meanwhile, and the pairs that they find leave at once.
///
/// Threads begin far from each other and take blocks in a row: who writes next to what another one is just writing
/// waits for its cache lines.
class JointStages {
 public:
  /// Before a step, by one thread: `blocks` of stage 0, at least 1.
  void start(std::size_t stages, std::size_t blocks) {
    blocks_.assign(stages, 0);
    blocks_[0] = blocks;
    joined_.store(0, std::memory_order_relaxed);
    failed_.store(false, std::memory_order_relaxed);
    open(0);
  }

  /// Returns when all stages are done, and whether they are: not when a block threw, here or elsewhere. run(stage,
  /// block) runs a block, blocks(stage) is asked for by one thread when the stages before are done; neither may wait.
  template <class Blocks, class Run>
  bool join(const Blocks& blocks, const Run& run) {
    std::size_t stage = stage_.load(std::memory_order_acquire), block = 0;
    if (stage == blocks_.size()) return !failed_.load(std::memory_order_relaxed);
    const std::size_t first = first_lane(joined_.fetch_add(1, std::memory_order_relaxed));
    for (std::size_t lane = first;;) {
      const std::size_t now = stage_.load(std::memory_order_acquire);
      if (now == blocks_.size()) return !failed_.load(std::memory_order_relaxed);
      if (now != stage) lane = first;
      stage = now;
      if (!take(stage, lane, block)) {
        std::this_thread::yield();
        continue;
      }
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
  static constexpr std::size_t lanes = 16;

  /// 0, 8, 4, 12, 2 and so on.
  static std::size_t first_lane(std::size_t joined) {
    std::size_t lane = 0;
    for (std::size_t bit = 1; bit < lanes; bit *= 2) lane = 2 * lane + ((joined & bit) != 0 ? 1 : 0);
    return lane;
  }
  std::size_t lane_begin(std::size_t stage, std::size_t lane) const { return lane * blocks_[stage] / lanes; }

  /// Searches from `lane` on, and leaves it where a block was.
  bool take(std::size_t stage, std::size_t& lane, std::size_t& block) {
    for (std::size_t tried = 0; tried < lanes; ++tried, lane = (lane + 1) % lanes) {
      const std::size_t end = lane_begin(stage, lane + 1);
      std::uint64_t next = next_[lane].load(std::memory_order_acquire);
      while (next >> 32 == stage && (next & 0xffffffffu) < end) {
        block = next & 0xffffffffu;
        if (next_[lane].compare_exchange_weak(next, next + 1, std::memory_order_acquire)) return true;
      }
    }
    return false;
  }

  void open(std::size_t stage) {
    done_.store(0, std::memory_order_relaxed);
    for (std::size_t lane = 0; stage != blocks_.size() && lane < lanes; ++lane)
      next_[lane].store(std::uint64_t{stage} << 32 | lane_begin(stage, lane), std::memory_order_release);
    stage_.store(stage, std::memory_order_release);
  }

  template <class Blocks>
  void finish(std::size_t stage, bool ran, const Blocks& blocks) {
    if (!ran) failed_.store(true, std::memory_order_relaxed);
    if (done_.fetch_add(1, std::memory_order_acq_rel) + 1 != blocks_[stage]) return;
    const bool failed = failed_.load(std::memory_order_relaxed);
    do {
      if (++stage == blocks_.size()) break;
      blocks_[stage] = failed ? 0 : blocks(stage);
    } while (blocks_[stage] == 0);
    open(stage);
  }

  alignas(64) std::atomic<std::size_t> stage_{0};
  alignas(64) std::atomic<std::size_t> done_{0};
  // Of each lane: stage in the high half, next block in the low half. A block can only be taken of the stage it belongs
  // to.
  alignas(64) std::array<std::atomic<std::uint64_t>, lanes> next_{};
  std::atomic<std::size_t> joined_{0};
  std::atomic<bool> failed_{false};
  std::vector<std::size_t> blocks_;  // of each stage that was reached
};

}  // namespace tandem
