// The support function of a hull's vertices in single precision.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/narrowphase/pose.h"

namespace tandem {

class WorkMeter;

/// A hull's vertices as a search for the farthest one along a direction reads them: in single precision, about a point
/// between them, in a unit in which the longest coordinate is between 1 and 2. What that leaves open is decided among
/// the few vertices within `slack` of the farthest, in double.
///
/// Up to 64 vertices are all searched. Of more, those that can be the farthest at all, by the direction's chamber:
/// the 48 cones into which the planes x = 0, y = 0, z = 0, |x| = |y|, |y| = |z|, |z| = |x| divide space. Over a cone a
/// vertex is beaten everywhere by another one that beats it along the three edges of the cone, so few are left in
/// each: about 14 of 256 on a ball.
class SupportMap {
 public:
  static constexpr std::size_t block = 8;         ///< vertices a block, the widest vector of floats in use
  static constexpr std::size_t searched_all = 8;  ///< blocks up to which there are no chambers

  /// Ascending by index; the last one is repeated to fill the block.
  struct alignas(128) Block {
    float x[block], y[block], z[block];
    std::uint32_t index[block];
  };
  struct Range {
    std::uint32_t first = 0;
    std::uint32_t blocks = 0;
  };

  SupportMap() = default;
  /// Counts its work: the meter may end it (WorkStopped).
  SupportMap(std::span<const Vec3> vertices, const Vec3& middle, WorkMeter& meter);

  bool empty() const { return blocks_.empty(); }
  std::size_t memory() const { return blocks_.capacity() * sizeof(Block) + chambers_.capacity() * sizeof(Range); }
  const Block* blocks() const { return blocks_.data(); }
  std::span<const Range> chambers() const { return chambers_; }  ///< by `candidates`, or empty
  Range candidates(double dx, double dy, double dz) const {
    if (chambers_.empty()) return {0, static_cast<std::uint32_t>(blocks_.size())};
    const double x = std::abs(dx), y = std::abs(dy), z = std::abs(dz);
    const unsigned signs = (std::signbit(dx) ? 1u : 0u) | (std::signbit(dy) ? 2u : 0u) | (std::signbit(dz) ? 4u : 0u);
    const unsigned order = (x > y ? 8u : 0u) | (y > z ? 16u : 0u) | (z > x ? 32u : 0u);
    return chambers_[signs | order];
  }
  /// Multiplied with the absolute coordinates of a direction: by how much a vertex may be behind the farthest in single
  /// precision and still be the farthest in double.
  const std::array<float, 3>& slack() const { return slack_; }
  double unit() const { return unit_; }
  const Vec3& middle() const { return middle_; }

 private:
  void fill(Block& block, std::span<const Vec3> vertices, std::span<const std::uint32_t> kept) const;

  std::vector<Block> blocks_;
  std::array<float, 3> slack_{};
  double unit_ = 1;  ///< a power of two
  Vec3 middle_ = Vec3::Zero();
  std::vector<Range> chambers_;  ///< by `candidates`, or empty
};

}  // namespace tandem
