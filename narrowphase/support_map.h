#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// Which vertices of a hull can be the farthest along a direction, by the direction's chamber: the 48 cones into
/// which the planes x = 0, y = 0, z = 0, |x| = |y|, |y| = |z|, |z| = |x| divide space. Over a cone a vertex is
/// beaten everywhere by another one that beats it along the three edges of the cone, so few are left in each: about
/// 5 of 32 on a ball, 14 of 256.
class SupportMap {
 public:
  static constexpr std::size_t block = 8;  ///< candidates a block, the widest vector of doubles

  /// Candidates of a chamber: blocks of x[8], y[8], z[8] and of their 8 indices, ascending; the last one repeated.
  struct Range {
    std::uint32_t first = 0;  ///< block
    std::uint32_t blocks = 0;
  };

  SupportMap() = default;
  explicit SupportMap(std::span<const Vec3> vertices);

  const Range& candidates(const Vec3& d) const {
    const double x = std::abs(d[0]), y = std::abs(d[1]), z = std::abs(d[2]);
    const unsigned signs =
        (std::signbit(d[0]) ? 1u : 0u) | (std::signbit(d[1]) ? 2u : 0u) | (std::signbit(d[2]) ? 4u : 0u);
    const unsigned order = (x > y ? 8u : 0u) | (y > z ? 16u : 0u) | (z > x ? 32u : 0u);
    return chambers_[signs | order];
  }
  const double* xyz(const Range& r) const { return xyz_.data() + 3 * block * r.first; }
  const std::uint32_t* index(const Range& r) const { return index_.data() + block * r.first; }
  bool empty() const { return xyz_.empty(); }

 private:
  std::array<Range, 64> chambers_{};
  std::vector<double> xyz_;
  std::vector<std::uint32_t> index_;
};

}  // namespace tandem
