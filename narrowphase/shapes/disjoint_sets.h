#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <numeric>
#include <vector>

namespace tandem {

/// Numbers 0 to n - 1 in sets that are joined; a set is called by the least number in it, in whatever order it was
/// joined (Tarjan, Efficiency of a good but not linear set union algorithm, 1975, with halved paths).
class DisjointSets {
 public:
  DisjointSets(std::size_t n, std::pmr::memory_resource* memory) : parent_(n, memory) {
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
