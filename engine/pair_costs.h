#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/broadphase/pair.h"

namespace tandem {

/// Guesses by the last step which pairs cost the most, from one number a body: the cost of its costliest pair. It
/// decides who is begun first, never an answer.
class PairCosts {
 public:
  /// What was learned since is from now on what is guessed from.
  void begin_step(std::size_t bodies) {
    before_.swap(now_);
    before_.resize(bodies);
    now_.assign(bodies, 0);
    const auto most = std::max_element(before_.begin(), before_.end());
    least_ = std::max(fills_a_batch, most == before_.end() ? 0 : *most / 2);
  }

  /// Both bodies had a pair that cost at least half of the costliest of all.
  bool is_costliest(Pair pair) const { return std::min(before_[pair.a], before_[pair.b]) >= least_; }

  /// From many threads at once.
  void learn(Pair pair, std::chrono::nanoseconds took) {
    const auto ns = static_cast<std::uint32_t>(std::clamp<std::int64_t>(took.count(), 0, UINT32_MAX));
    for (const std::uint32_t body : {pair.a, pair.b}) {
      const std::atomic_ref<std::uint32_t> cost(now_[body]);
      std::uint32_t known = cost.load(std::memory_order_relaxed);
      while (known < ns && !cost.compare_exchange_weak(known, ns, std::memory_order_relaxed)) {
      }
    }
  }

 private:
  static constexpr std::uint32_t fills_a_batch = 15'000;  // ns; cheaper ones travel together

  std::uint32_t least_ = fills_a_batch;
  std::vector<std::uint32_t> before_, now_;  // ns, one a body
};

}  // namespace tandem
