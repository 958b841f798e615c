#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/batch.h"

namespace tandem {

/// Guesses by the last step which pairs cost the most, from one number a body: the cost of its costliest pair. It
/// decides who is begun first, never an answer.
class PairCosts {
 public:
  /// From what cost (ns) on a pair is one of the costliest, if the costliest of all takes `most_ns`.
  static double costliest_from(double most_ns) {
    return std::max(static_cast<double>(shortest_batch.count()), 0.5 * most_ns);
  }

  /// What was learned since is from now on what is guessed from.
  void begin_step(std::size_t bodies) {
    before_.swap(now_);
    before_.resize(bodies);
    now_.assign(bodies, 0);
    const auto most = std::max_element(before_.begin(), before_.end());
    least_ = costliest_from(most == before_.end() ? 0 : *most);
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
  double least_ = costliest_from(0);
  std::vector<std::uint32_t> before_, now_;  // ns, one a body
};

}  // namespace tandem
