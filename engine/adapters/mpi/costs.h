// The measured cost of each body, by which regions are balanced.
#pragma once
#include <atomic>
#include <cstdint>
#include <vector>

#include "bodies.h"
#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/report.h"

namespace tandem::mpi {

/// The cost of each body, from a step's measured times: a share of the broad phase, and the narrow phase of the pairs
/// at its place, where pairs with meshes have a cost of their own.
class Costs {
 public:
  void begin(const Bodies& bodies) {
    changes_ = bodies.changes();
    light_.assign(bodies.scene().indices(), 0);
    heavy_.assign(bodies.scene().indices(), 0);
  }
  /// True if pairs were counted for the present bodies.
  bool known(const Bodies& bodies) const { return !light_.empty() && changes_ == bodies.changes(); }
  /// Counts a pair that is narrowed on this rank. From many threads at once.
  void count(const Bodies& bodies, Pair pair) {
    const Scene& scene = bodies.scene();
    const Shape &a = scene.shape_of(pair.a), &b = scene.shape_of(pair.b);
    // A pair's place is that of the smaller body; a half-space is everywhere.
    std::uint32_t at = pair.a, other = pair.b;
    if (!a.is_bounded() || (b.is_bounded() && b.size() < a.size())) std::swap(at, other);
    if (!bodies.owns(at)) std::swap(at, other);
    if (!bodies.owns(at) || !scene.shape_of(at).is_bounded()) return;
    const bool is_heavy = !(a.is_convex() && b.is_convex()) && a.is_bounded() && b.is_bounded();
    std::atomic_ref<std::uint32_t>((is_heavy ? heavy_ : light_)[at]).fetch_add(1, std::memory_order_relaxed);
  }
  /// Weights in ns of the bodies that this rank owns, in the order of their indices.
  std::vector<float> weights(const Bodies& bodies, const ExecutionReport& execution) const {
    double light = 0, heavy = 0, owned = 0;
    for (std::uint32_t i = 0; i < light_.size(); ++i)
      if (bodies.scene().alive(i) && bodies.owns(i)) light += light_[i], heavy += heavy_[i], ++owned;
    constexpr double ns = 1e6;
    const double broad = owned > 0 ? ns * execution.broad_ms / owned : 0;
    // If heavy pairs were not measured separately, all pairs cost the same.
    const bool apart = execution.heavy_ms > 0 && heavy > 0 && light > 0;
    const double narrow = execution.narrow_ms;
    const double all = light + heavy > 0 ? ns * narrow / (light + heavy) : 0;
    const double light_ns = apart ? ns * std::max(0.0, narrow - execution.heavy_ms) / light : all;
    const double heavy_ns = apart ? ns * execution.heavy_ms / heavy : all;
    std::vector<float> out;
    for (std::uint32_t i = 0; i < light_.size(); ++i)
      if (bodies.scene().alive(i) && bodies.owns(i))
        out.push_back(static_cast<float>(1 + broad + light_ns * light_[i] + heavy_ns * heavy_[i]));
    return out;
  }

 private:
  std::vector<std::uint32_t> light_, heavy_;  // pairs of each body
  std::uint64_t changes_ = 0;
};

}  // namespace tandem::mpi
