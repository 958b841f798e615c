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
  const Hull* hull = nullptr;  ///< null for a triangle of a mesh
  double size = 0;
};

ConvexView view(const Shape& shape);  ///< shape.is_convex()
ConvexView view_box(const std::array<double, 4>& half);
ConvexView view_triangle(const std::array<Vec3, 3>& vertices);  ///< must outlive the view

}  // namespace tandem
