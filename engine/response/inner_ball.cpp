// A ball inside a shape.
#include "response/inner_ball.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <stdexcept>

namespace tandem {
namespace {

/// The shape, made solid if it is a closed mesh; empty if it has no interior.
std::optional<Shape> with_inside(const Shape& shape) {
  if (shape.is_solid()) return shape;
  if (shape.kind() != ShapeKind::mesh) return std::nullopt;
  try {
    const auto vertices = shape.vertices();
    const auto triangles = shape.triangles();
    return Shape(Mesh{{vertices.begin(), vertices.end()}, {triangles.begin(), triangles.end()}, true});
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // not closed
  }
}

/// The largest ball about the point inside the surface.
InnerBall ball_about(const NarrowPhase& narrow, const Shape& solid, const Vec3& centre) {
  Pose at;
  at.translation = centre;
  const PairAnswer inside = narrow.solve(Sphere{0}, at, solid, Pose{}, Request::distance);
  return {centre, std::max(0.0, -inside.signed_distance - inside.error_bound)};
}

}  // namespace

InnerBall inner_ball(const NarrowPhase& narrow, const Shape& shape) {
  InnerBall best{shape.mass().centre, 0};
  const std::optional<Shape> solid = with_inside(shape);
  if (!solid) return best;
  best = ball_about(narrow, *solid, best.centre);
  constexpr std::size_t places = 32;
  const auto triangles = shape.kind() == ShapeKind::mesh ? solid->triangles() : solid->triangles().first(0);
  for (std::size_t i = 0; i < std::min(places, triangles.size()); ++i) {
    const auto& [p, q, r] = triangles[i * triangles.size() / std::min(places, triangles.size())];
    const Vec3 a = solid->vertices()[p], b = solid->vertices()[q], c = solid->vertices()[r];
    const Vec3 inward = (c - a).cross(b - a).stableNormalized();
    for (double depth = solid->size() / 4; depth > solid->size() / 100; depth /= 2)
      if (const InnerBall ball = ball_about(narrow, *solid, (a + b + c) / 3 + depth * inward);
          ball.radius > best.radius)
        best = ball;
  }
  return best;
}

}  // namespace tandem
