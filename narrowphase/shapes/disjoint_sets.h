// Disjoint sets (union-find).
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <numeric>
#include <vector>

namespace tandem {

/// Disjoint sets of the numbers 0 to n - 1 (union-find: Tarjan, Efficiency of a good but not linear set union
/// algorithm, 1975, with path halving). A set is represented by its least number, in whatever order it was joined.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n, std::pmr::memory_resource* memory = std::pmr::get_default_resource())
      : parent_(n, memory) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t i, std::uint32_t j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::pmr::vector<std::uint32_t> parent_;
};

}  // namespace tandem
