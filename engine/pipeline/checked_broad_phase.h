// Checks the pairs of a user's broad phase.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>

#include "tandem/broadphase/broad_phase.h"

namespace tandem {

/// A user's broad phase, whose pairs are checked before they are used: bodies that do not exist would otherwise be
/// read.
class CheckedBroadPhase final : public BroadPhase {
 public:
  /// `notes_twice`: a duplicate pair is refused at once, by a set of all pairs, which takes some 100 ns a pair; needed
  /// where two threads on the same pair would conflict.
  CheckedBroadPhase(std::unique_ptr<BroadPhase> own, bool notes_twice)
      : own_(std::move(own)), seen_(notes_twice ? std::make_unique<PairSet>() : nullptr) {
    if (own_ == nullptr) throw std::invalid_argument("own_broad_phase: made none, allowed: a broad phase");
  }

  void expect(const PairFilter& filter) override { own_->expect(filter); }
  void expect_changes(std::span<const std::uint8_t> changed) override { own_->expect_changes(changed); }
  void expect_only_changes() override { own_->expect_only_changes(); }
  std::size_t begin(const BoxArray& boxes) override {
    boxes_ = boxes.size();
    if (seen_) seen_->clear();
    const std::size_t stages = own_->begin(boxes);
    if (stages == 0) throw std::invalid_argument("own_broad_phase: begin() returned 0 stages, allowed: at least 1");
    return stages;
  }
  std::size_t blocks(std::size_t stage) const override { return own_->blocks(stage); }
  void run(std::size_t stage, std::size_t block) override { own_->run(stage, block); }
  void emit(std::size_t block, PairSink& sink) override {
    Gate gate(boxes_, block, sink, seen_.get());
    own_->emit(block, gate);
    gate.flush();
  }
  BroadPhaseKind kind() const override { return own_->kind(); }
  std::string_view reason() const override { return own_->reason(); }
  std::size_t memory() const override { return own_->memory(); }

 private:
  /// The pairs of a step, from many threads.
  class PairSet {
   public:
    void clear() {
      for (Part& part : parts_) part.keys.clear();
    }
    /// False if it is there already.
    bool add(Pair pair) {
      const auto [low, high] = std::minmax(pair.a, pair.b);
      const std::uint64_t key = std::uint64_t{high} << 32 | low;
      Part& part = parts_[(low + high) % parts_.size()];
      const std::scoped_lock lock(part.mutex);
      return part.keys.insert(key).second;
    }

   private:
    struct alignas(64) Part {
      std::mutex mutex;
      std::unordered_set<std::uint64_t> keys;
    };
    std::array<Part, 64> parts_;
  };

  /// Passes on the pairs of a block if they are valid.
  class Gate final : public PairSink {
   public:
    Gate(std::size_t boxes, std::size_t block, PairSink& sink, PairSet* seen)
        : boxes_(boxes), block_(block), sink_(sink), seen_(seen) {
      filter_ = &all_;
      buffer_ = pairs_.data();
      capacity_ = pairs_.size();
    }
    void flush() {
      for (const Pair pair : std::span(pairs_).first(std::exchange(count_, 0))) {
        if (pair.a == pair.b || std::max(pair.a, pair.b) >= boxes_) refuse(pair);
        if (seen_ != nullptr && !seen_->add(pair)) refuse_twice(pair);
        sink_.put(pair.a, pair.b);
      }
    }

   private:
    void full() override { flush(); }
    [[noreturn]] void refuse(Pair pair) const {
      throw std::invalid_argument("own_broad_phase: block " + std::to_string(block_) + " put the pair (" +
                                  std::to_string(pair.a) + ", " + std::to_string(pair.b) +
                                  "), allowed: two different boxes of " + std::to_string(boxes_));
    }

    // With the message for a list that has the pair twice.
    [[noreturn]] static void refuse_twice(Pair pair) {
      const auto [low, high] = std::minmax(pair.a, pair.b);
      throw std::invalid_argument("own_broad_phase: put the pair (" + std::to_string(low) + ", " +
                                  std::to_string(high) + ") twice, allowed: each pair once");
    }

    std::size_t boxes_, block_;
    PairSink& sink_;
    PairSet* seen_;
    PairFilter all_;
    std::array<Pair, 128> pairs_;
  };

  std::unique_ptr<BroadPhase> own_;
  std::unique_ptr<PairSet> seen_;  // null: duplicates are not checked
  std::size_t boxes_ = 0;
};

}  // namespace tandem
