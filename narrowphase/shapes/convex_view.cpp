#include "shapes/convex_view.h"

#include <cmath>

#include "shapes/hull.h"

namespace tandem {

ConvexView view(const Shape& shape) {
  ConvexView v{.kind = shape.kind(), .param = {}, .vertices = {}, .hull = nullptr, .size = shape.size()};
  switch (shape.kind()) {
    case ShapeKind::sphere:
      v.param[0] = shape.radius();
      break;
    case ShapeKind::capsule:
    case ShapeKind::cylinder:
    case ShapeKind::cone:
      v.param = {shape.radius(), shape.length(), 0, 0};
      break;
    case ShapeKind::box:
    case ShapeKind::ellipsoid:
    case ShapeKind::halfspace: {
      const Vec3 p = shape.half_size();  // the first three parameters, whatever they mean for the kind
      v.param = {p[0], p[1], p[2], shape.offset()};
      break;
    }
    case ShapeKind::convex:
    case ShapeKind::triangle:
      v.hull = &shape.hull();
      v.vertices = v.hull->vertices;
      break;
    case ShapeKind::mesh:
      break;
  }
  return v;
}

ConvexView view_box(const std::array<double, 4>& half) {
  const double size = 2 * std::sqrt(half[0] * half[0] + half[1] * half[1] + half[2] * half[2]);
  return {.kind = ShapeKind::box, .param = half, .vertices = {}, .hull = nullptr, .size = size};
}

ConvexView view_triangle(const std::array<Vec3, 3>& vertices) {
  const Vec3 lo = vertices[0].cwiseMin(vertices[1]).cwiseMin(vertices[2]);
  const Vec3 hi = vertices[0].cwiseMax(vertices[1]).cwiseMax(vertices[2]);
  return {.kind = ShapeKind::triangle, .param = {}, .vertices = vertices, .hull = nullptr, .size = (hi - lo).norm()};
}

}  // namespace tandem
