// Synthetic work for executors.
#pragma once
#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <random>
#include <stdexcept>

#include "tandem/broadphase/broad_phase.h"
#include "tandem/flowgraph/executor.h"

namespace tandem {

/// Random boxes and a narrow phase that is plain arithmetic on the pair: every pair's answer is known, two thirds of
/// the pairs collide, and a pair has up to three contacts.
class SyntheticWork final : public StepWork {
 public:
  SyntheticWork(std::size_t n, float extent, unsigned seed, BroadPhaseKind kind = BroadPhaseKind::brute)
      : broad_phase_(make_broad_phase(kind)) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> place(0, extent);
    source_.resize(n);
    boxes_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      const float x = place(random), y = place(random), z = place(random);
      source_.set(i, {{x, y, z}, {x + 1, y + 1, z + 1}});
    }
  }

  void ended_by(std::function<bool()> ended) override { has_ended = std::move(ended); }
  std::size_t begin() override {
    stages_ = 1 + broad_phase_->begin(boxes_);
    return stages_;
  }
  std::size_t blocks(std::size_t stage) const override {
    if (no_tiles && stage + 1 == stages_) return 0;
    return stage == 0 ? (boxes_.size() + 99) / 100 : broad_phase_->blocks(stage - 1);
  }
  void run(std::size_t stage, std::size_t block) override {
    if (stage > 0) return broad_phase_->run(stage - 1, block);
    for (std::size_t i = block * 100; i < std::min(boxes_.size(), block * 100 + 100); ++i) boxes_.set(i, source_[i]);
  }
  void emit(std::size_t block, PairSink& sink) override {
    if (on_tile) on_tile(block);
    broad_phase_->emit(block, sink);
  }
  const PairFilter& filter() const override { return filter_; }
  std::size_t keep(std::span<Pair> pairs) const override { return on_keep ? on_keep(pairs) : pairs.size(); }
  HeavyPairs heavy_first(std::span<Pair> pairs, std::chrono::nanoseconds) const override {
    if (!is_heavy) return {};
    const auto rest = std::partition(pairs.begin(), pairs.end(), is_heavy);
    const auto heavy =
        std::partition(pairs.begin(), rest, [this](Pair pair) { return is_costliest && is_costliest(pair); });
    return {static_cast<std::size_t>(heavy - pairs.begin()), static_cast<std::size_t>(rest - pairs.begin())};
  }
  void narrow(Batch& batch) const override {
    for (std::size_t i = 0; i < batch.count; ++i) {
      const Pair pair = batch.pairs[i];
      if (on_pair) on_pair(pair);
      answer(pair, batch.results, batch.contacts);
    }
  }
  std::size_t bodies() const override { return boxes_.size(); }

  /// The answer by a double loop.
  ContactList expected() const {
    ContactList list;
    for (std::uint32_t a = 0; a < source_.size(); ++a)
      for (std::uint32_t b = a + 1; b < source_.size(); ++b)
        if (overlap(source_[a], source_[b])) answer({a, b}, list.pairs, list.contacts);
    return list;
  }

  std::function<void(std::size_t)> on_tile;             // may throw
  std::function<void(Pair)> on_pair;                    // may throw
  std::function<std::size_t(std::span<Pair>)> on_keep;  // may throw
  std::function<bool(Pair)> is_heavy, is_costliest;
  bool no_tiles = false;
  std::function<bool()> has_ended;  // set by the executor

 private:
  static void answer(Pair pair, std::vector<PairResult>& results, std::vector<Contact>& contacts) {
    if ((pair.a + pair.b) % 3 == 0) return;
    PairResult result{pair.a, pair.b, static_cast<std::uint32_t>(contacts.size()), (pair.a ^ pair.b) % 4, {}};
    result.answer.collide = true;
    for (std::uint32_t k = 0; k < result.contact_count; ++k)
      contacts.push_back({Vec3(pair.a, pair.b, k), Vec3::UnitZ(), 1.0 / (1 + pair.a + pair.b + k), k});
    results.push_back(result);
  }

  std::unique_ptr<BroadPhase> broad_phase_;
  BoxArray source_, boxes_;
  PairFilter filter_;
  std::size_t stages_ = 0;
};

}  // namespace tandem
