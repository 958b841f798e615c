#pragma once
#include <array>
#include <span>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Half sizes of a box, as in Shape and ConvexView; the fourth is 0.
using HalfSize = std::array<double, 4>;

/// What a convex solver needs of a shape, without owning it: the same solver then serves a shape, a triangle of a
/// mesh or a point. `vertices` is set for convex and triangle, in the shape's frame; `param` as in Shape.
struct ConvexView {
  ShapeKind kind;
  std::array<double, 4> param{};
  std::span<const Vec3> vertices;
  const detail::Hull* hull = nullptr;  ///< null for a triangle of a mesh
  double size = 0;
};

ConvexView view(const Shape& shape);  ///< shape.is_convex()
ConvexView view_box(const std::array<double, 4>& half);

/// A mesh's triangle. One without area is seen as the segment or the point that it is, as its hull is: solvers count
/// on corners that are extreme.
class TriangleView {
 public:
  explicit TriangleView(const std::array<Vec3, 3>& corners);  ///< must outlive it
  TriangleView(const TriangleView&) = delete;
  TriangleView& operator=(const TriangleView&) = delete;

  operator const ConvexView&() const { return view_; }

 private:
  void drop_inner_corners(const std::array<Vec3, 3>& corners, double area);

  std::array<Vec3, 2> ends_;  ///< of a segment, where view_ has these corners
  ConvexView view_;
};

}  // namespace tandem
