// Stages of blocks within one stage of a broad phase.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

namespace tandem {

/// Stages of blocks within one stage of a broad phase. A thread that needs their results helps with them, and waits for
/// the blocks that others have begun; threads that do not need them can go on, and the pairs that these find leave at
/// once.
///
/// Threads begin at blocks far from each other and take consecutive ones: writing next to memory that another thread is
/// writing would wait for its cache lines.
class JointStages {
 public:
  /// Before a step, by one thread: begins with `blocks` blocks of stage 0, at least 1.
  void start(std::size_t stages, std::size_t blocks) {
    blocks_.assign(stages, 0);
    blocks_[0] = blocks;
    joined_.store(0, std::memory_order_relaxed);
    failed_.store(false, std::memory_order_relaxed);
    open(0);
  }

  /// Works until all stages are done and returns true; false if a block threw, here or on another thread. run(stage,
  /// block) runs a block; blocks(stage) is called by one thread when the earlier stages are done. Neither may wait.
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
      // The destructor marks the end also when memory runs out, so that no thread waits forever.
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

  /// The lane where a thread begins: 0, 8, 4, 12, 2 and so on, far from the earlier threads'.
  static std::size_t first_lane(std::size_t joined) {
    std::size_t lane = 0;
    for (std::size_t bit = 1; bit < lanes; bit *= 2) lane = 2 * lane + ((joined & bit) != 0 ? 1 : 0);
    return lane;
  }
  std::size_t lane_begin(std::size_t stage, std::size_t lane) const { return lane * blocks_[stage] / lanes; }

  /// Searches the lanes from `lane` on for a block; sets `lane` to where it found one.
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
  // The next block of each lane: stage in the high half, block in the low half, so that a block can only be taken of
  // the stage it belongs to.
  alignas(64) std::array<std::atomic<std::uint64_t>, lanes> next_{};
  std::atomic<std::size_t> joined_{0};
  std::atomic<bool> failed_{false};
  std::vector<std::size_t> blocks_;  // blocks of each stage reached so far
};

}  // namespace tandem
