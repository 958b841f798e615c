// The table of kinds agrees with the shapes.
#include "shapes/kind_rows.h"

#include "catch.h"
#include "random_pairs.h"
#include "shapes/support.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("kinds: a shape says of itself what its kind's row says") {
  Random r(31);
  for (const KindRow& row : kind_rows) {
    const Shape shape = random_shape(row.kind, r);
    CAPTURE(name(row.kind));
    CHECK(shape.kind() == row.kind);
    CHECK(name(shape.kind()) == row.name.value);
    CHECK(shape.is_convex() == row.convex);
    CHECK(shape.is_bounded() == row.bounded);
  }
}

TEST_CASE("kinds: a core is flat where its support stays at one corner, and round where it does not") {
  Random r(32);
  for (const KindRow& row : kind_rows) {
    if (!row.convex || !row.bounded) continue;
    CAPTURE(name(row.kind));
    int same = 0;
    constexpr int tries = 400;
    for (int i = 0; i < tries; ++i) {
      const Shape shape = random_shape(row.kind, r);
      const ConvexView v = view(shape);
      const Vec3 d = r.direction(), beside = d + 1e-6 * r.direction();
      same += core_support(v, d) == core_support(v, beside) ? 1 : 0;
    }
    // A round body may have a corner: its apex.
    CHECK((same > 0.97 * tries) == (row.core == CoreSurface::flat));
  }
}

TEST_CASE("kinds: bounds are those of the core and of the ball swept over it") {
  Random r(33);
  for (const KindRow& row : kind_rows) {
    if (!row.convex || !row.bounded) continue;
    for (int i = 0; i < 20; ++i) {
      const Shape shape = random_shape(row.kind, r);
      const Pose pose = random_pose(r, 1);
      const ConvexView v = view(shape);
      const Bounds bounds = shape.bounds(pose);
      for (int k = 0; k < 3; ++k) {
        CAPTURE(name(row.kind), i, k);
        const Vec3 along = pose.rotation.transpose().col(k);
        const double most = pose.translation[k] + along.dot(core_support(v, along)) + core_radius(v);
        CHECK(std::abs(bounds.hi[k] - most) <= 1e-12 * (shape.size() + 1));
      }
    }
  }
}
