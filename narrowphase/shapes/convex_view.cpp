// The view of a shape that convex solvers use.
#include "shapes/convex_view.h"

#include <cmath>

#include "shapes/hull.h"
#include "shapes/shape_insides.h"
#include "tolerances.h"

namespace tandem {

ConvexView view(const Shape& shape) {
  ConvexView v{
      .kind = shape.kind(), .param = shape.parameters(), .vertices = {}, .hull = nullptr, .size = shape.size()};
  if (has_hull(shape)) {
    v.hull = &hull_of(shape);
    v.vertices = v.hull->vertices;
  }
  return v;
}

ConvexView view_box(const std::array<double, 4>& half) {
  const double size = 2 * std::sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
  return {.kind = ShapeKind::box, .param = half, .vertices = {}, .hull = nullptr, .size = size};
}

bool axis_is_lost(const ConvexView& view, double reach) {
  return view.kind == ShapeKind::capsule && view.param[1] <= tolerance::lost * reach;
}

ConvexView ball_of(ConvexView body) {
  body.kind = ShapeKind::sphere;
  return body;
}

namespace {

double box_diagonal(const std::array<Vec3, 3>& corners) {
  const Vec3 lo = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]);
  const Vec3 hi = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]);
  return (hi - lo).norm();
}

}  // namespace

TriangleView::TriangleView(const std::array<Vec3, 3>& corners)
    : view_{.kind = ShapeKind::triangle,
            .param = {},
            .vertices = corners,
            .hull = nullptr,
            .size = box_diagonal(corners)} {
  // No side is longer than the size: with a larger area no height is below the limit. Squares may underflow, but not
  // exceed.
  const double limit = tolerance::flat_hull * view_.size * view_.size;
  const Vec3 area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  if (!(area.squaredNorm() > limit * limit)) drop_inner_corners(corners, area.norm());
}

void TriangleView::drop_inner_corners(const std::array<Vec3, 3>& corners, double area) {
  std::size_t longest = 0;
  double length = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (const double side = (corners[(i + 1) % 3] - corners[i]).norm(); side > length) longest = i, length = side;
  if (area > tolerance::flat_hull * length * length) return;
  ends_ = {corners[longest], corners[(longest + 1) % 3]};
  view_.vertices = std::span(ends_).first(length > 0 ? 2 : 1);
}

}  // namespace tandem
