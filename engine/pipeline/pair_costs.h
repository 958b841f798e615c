// Estimated costs of pairs.
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

/// Estimates from the last step which pairs cost the most, with one number a body: the cost of its costliest pair. It
/// decides the order of work, never an answer.
class PairCosts {
 public:
  /// The cost (ns) from which on a pair is one of the costliest, if the costliest of all takes `most_ns` and a batch
  /// should take `batch`.
  static double costliest_from(double most_ns, std::chrono::nanoseconds batch) {
    return std::max(static_cast<double>(batch.count()), 0.5 * most_ns);
  }

  /// From now on estimates use what was learned since the last call.
  void begin_step(std::size_t bodies) {
    before_.swap(now_);
    before_.resize(bodies);
    now_.assign(bodies, 0);
    const auto most = std::max_element(before_.begin(), before_.end());
    most_ = most == before_.end() ? 0 : *most;
  }

  /// True if both bodies had a pair that cost at least as much as a batch should take, and half of the costliest of
  /// all.
  bool is_costliest(Pair pair, std::chrono::nanoseconds batch) const {
    return std::min(before_[pair.a], before_[pair.b]) >= costliest_from(most_, batch);
  }

  /// From many threads at once. Costs below that of a batch are not stored, so that their cache line is not written.
  void learn(Pair pair, std::chrono::nanoseconds took) {
    const auto ns = static_cast<std::uint32_t>(std::clamp<std::int64_t>(took.count(), 0, UINT32_MAX));
    if (took < shortest_batch) return;
    for (const std::uint32_t body : {pair.a, pair.b}) {
      const std::atomic_ref<std::uint32_t> cost(now_[body]);
      std::uint32_t known = cost.load(std::memory_order_relaxed);
      while (known < ns && !cost.compare_exchange_weak(known, ns, std::memory_order_relaxed)) {
      }
    }
  }

 private:
  std::uint32_t most_ = 0;
  std::vector<std::uint32_t> before_, now_;  // ns, one a body
};

}  // namespace tandem
