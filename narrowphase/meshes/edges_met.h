// A set of visited edges.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "shapes/mesh_model.h"

namespace tandem {

/// The edges of a mesh that have been visited: a hash table with as many lists as triangles.
class EdgesMet {
 public:
  explicit EdgesMet(std::size_t triangles) : last_(std::bit_ceil(triangles + 1), no_index) {
    met_.reserve(triangles * 3 / 2 + 3);
  }

  /// True the first time an edge is given.
  bool is_new(const std::array<std::uint32_t, 2>& edge) {
    // By both ends: a vertex may have as many edges as there are triangles (Knuth's multiplicative hash).
    const std::uint64_t number = (std::uint64_t{edge[0]} << 32 | edge[1]) * 0x9e3779b97f4a7c15u;
    std::uint32_t& last = last_[(number >> 32) & (last_.size() - 1)];
    for (std::uint32_t e = last; e != no_index; e = met_[e].before)
      if (met_[e].edge == edge) return false;
    met_.push_back({edge, last});
    last = static_cast<std::uint32_t>(met_.size() - 1);
    return true;
  }

  /// The longest list, which bounds the cost of a query.
  std::size_t longest_list() const {
    std::size_t longest = 0;
    for (const std::uint32_t last : last_) {
      std::size_t length = 0;
      for (std::uint32_t e = last; e != no_index; e = met_[e].before) ++length;
      longest = std::max(longest, length);
    }
    return longest;
  }

 private:
  struct Met {
    std::array<std::uint32_t, 2> edge;
    std::uint32_t before;
  };
  std::vector<std::uint32_t> last_;  // the last of each list
  std::vector<Met> met_;
};

}  // namespace tandem
