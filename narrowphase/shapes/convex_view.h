// The view of a shape that convex solvers use.
#pragma once
#include <array>
#include <span>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The half sizes of a box, as in Shape and ConvexView; the fourth is 0.
using HalfSize = std::array<double, 4>;

/// The data of a shape that a convex solver needs, not owned, so that one solver serves shapes, triangles of meshes and
/// points. `vertices` is set for convex and triangle, in the shape's frame; `param` as in Shape.
struct ConvexView {
  ShapeKind kind;
  std::array<double, 4> param{};
  std::span<const Vec3> vertices;
  const detail::Hull* hull = nullptr;  ///< null for a triangle of a mesh
  double size = 0;
};

ConvexView view(const Shape& shape);  ///< shape.is_convex()
ConvexView view_box(const std::array<double, 4>& half);

/// True for a capsule so short relative to a pair's extent (metres) that its axis is lost to rounding.
bool axis_is_lost(const ConvexView& view, double reach);
/// The ball with the first parameter: a capsule's or an ellipsoid's radius.
ConvexView ball_of(ConvexView body);

/// The view of a mesh's triangle. A triangle without area becomes the segment or the point that it is, as does its
/// hull: solvers require vertices that are extreme.
class TriangleView {
 public:
  explicit TriangleView(const std::array<Vec3, 3>& corners);  ///< must outlive it
  TriangleView(const TriangleView&) = delete;
  TriangleView& operator=(const TriangleView&) = delete;

  operator const ConvexView&() const { return view_; }

 private:
  void drop_inner_corners(const std::array<Vec3, 3>& corners, double area);

  std::array<Vec3, 2> ends_;  ///< the ends, if the triangle is a segment
  ConvexView view_;
};

}  // namespace tandem
