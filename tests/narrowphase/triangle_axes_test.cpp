// Verdicts of triangles and boxes by separating axes.
#include "triangles/triangle_axes.h"

#include <cmath>

#include "catch.h"
#include "random_pairs.h"
#include "shapes/shape_insides.h"

using namespace tandem;
using namespace tandem::test;

namespace {

std::optional<bool> by_axes(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  const std::span<const Vec3, 3> corners_b(hull_of(b).vertices);
  if (a.kind() == ShapeKind::box) return box_triangle_collide(a.parameters(), pose_a, corners_b, pose_b);
  return triangles_collide(std::span<const Vec3, 3>(hull_of(a).vertices), pose_a, corners_b, pose_b);
}

}  // namespace

TEST_CASE("a triangle meets a triangle or a box by their axes as by their distance") {
  Random r(41);
  const NarrowPhase exact;
  for (const ShapeKind kind : {ShapeKind::box, ShapeKind::triangle}) {
    int decided = 0, pairs = 0, overlapping = 0;
    for (int i = 0; i < 3000; ++i) {
      const Shape a = random_shape(kind, r), b = random_shape(ShapeKind::triangle, r);
      const Pose pose_a{r.rotation(), i % 7 == 0 ? Vec3(1e5, -3e5, 2e5) : Vec3::Zero()};
      Pose pose_b{r.rotation(), pose_a.translation + 3 * r.direction()};
      const PairAnswer apart = exact.solve(a, pose_a, b, pose_b, Request::distance);
      if (apart.signed_distance <= 0) continue;
      const double gap = (i % 2 == 0 ? 1 : -1) * std::pow(10, r.in(i % 7 == 0 ? -8 : -12, -2));
      pose_b.translation += (gap - apart.signed_distance) * apart.normal;
      CAPTURE(i, gap, name(kind));
      ++pairs;
      const double distance = exact.solve(a, pose_a, b, pose_b, Request::distance).signed_distance;
      const std::optional<bool> collide = by_axes(a, pose_a, b, pose_b);
      if (!collide) continue;
      ++decided;
      REQUIRE(*collide == (distance <= 0));
      overlapping += *collide ? 1 : 0;
      REQUIRE(exact.solve(b, pose_b, a, pose_a, Request::collide).collide == *collide);
    }
    CHECK(pairs > 2000);
    CHECK(decided > 0.9 * pairs);
    CHECK(overlapping > 0.2 * pairs);
  }
}

TEST_CASE("the axes of triangles leave to others what rounding could decide") {
  const Shape flat{Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}}};
  const Shape upright{Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1)}}};
  const Shape box{Box{{2, 2, 2}}};
  const Pose origin;
  CHECK_FALSE(by_axes(flat, origin, flat, origin).has_value());
  CHECK_FALSE(by_axes(flat, origin, upright, origin).has_value());
  CHECK(by_axes(flat, origin, upright, Pose::at(0, 0, 1e-12)) == false);
  CHECK_FALSE(by_axes(box, origin, flat, Pose::at(0, 0, 1)).has_value());
  CHECK(by_axes(box, origin, flat, Pose::at(0, 0, 1 + 1e-12)) == false);
  CHECK_FALSE(by_axes(box, origin, flat, Pose::at(0.8, 0.8, 0)).has_value());  // parallel edges
  CHECK(by_axes(box, origin, flat, origin) == true);                           // its middle is inside
}
