// Axis-aligned boxes, and arrays of them by coordinate.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace tandem {

/// An axis-aligned box with float bounds; closed: two boxes that only touch overlap. lo <= hi on each axis.
struct Aabb {
  std::array<float, 3> lo;
  std::array<float, 3> hi;
};

/// Rounding to float: the smallest float that is not below `x`, and the largest not above it, so that a box in floats
/// holds the box in doubles. Finite in, finite out: clamped to the largest float, 3.4e38, which exceeds all bounds of
/// shapes and poses but the open sides of half-spaces and planes.
float round_up(double x);
float round_down(double x);

/// Boxes as a structure of arrays: one array a bound, aligned and padded with empty boxes (lo = +inf, hi = -inf),
/// which touch nothing, so that a kernel may read whole vectors past the end.
class BoxArray {
 public:
  /// Elements a kernel may read past `size()`.
  static constexpr std::size_t padding = 64;

  std::size_t size() const { return size_; }
  void resize(std::size_t n);

  std::size_t memory() const;  ///< bytes held

  /// Lower bounds on axis 0, 1 or 2: size() + padding elements.
  const float* lo(int axis) const { return bounds_[static_cast<std::size_t>(axis)].data(); }
  const float* hi(int axis) const { return bounds_[static_cast<std::size_t>(axis) + 3].data(); }

  float* lo(int axis) { return bounds_[static_cast<std::size_t>(axis)].data(); }
  float* hi(int axis) { return bounds_[static_cast<std::size_t>(axis) + 3].data(); }

  Aabb operator[](std::size_t i) const {
    return {{bounds_[0][i], bounds_[1][i], bounds_[2][i]}, {bounds_[3][i], bounds_[4][i], bounds_[5][i]}};
  }
  void set(std::size_t i, const Aabb& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds_[axis][i] = box.lo[axis];
      bounds_[axis + 3][i] = box.hi[axis];
    }
  }
  /// Makes the box of body i empty: the body is in no pair until its box is set again.
  void set_empty(std::size_t i);

 private:
  std::size_t size_ = 0;
  std::array<std::vector<float>, 6> bounds_;
};

inline bool overlap(const Aabb& p, const Aabb& q) {
  return p.lo[0] <= q.hi[0] && q.lo[0] <= p.hi[0] && p.lo[1] <= q.hi[1] && q.lo[1] <= p.hi[1] && p.lo[2] <= q.hi[2] &&
         q.lo[2] <= p.hi[2];
}

}  // namespace tandem
