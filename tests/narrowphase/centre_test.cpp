#include "centre_test.h"

#include <catch2/catch.hpp>

#include "random_pairs.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("the line of centres tells what the distance tells, and the same from both sides") {
  Random r(77);
  const NarrowPhase exact;
  int apart = 0, overlapping = 0, pairs = 0;
  for (const ShapeKind kind_a : bounded_convex)
    for (const ShapeKind kind_b : bounded_convex)
      for (int i = 0; i < 40; ++i) {
        const Shape a = random_shape(kind_a, r), b = random_shape(kind_b, r);
        const double away = r.in(0, 2.5), margin = i % 2 == 0 ? 0.0 : 0.1, far = i % 5 == 0 ? 1e5 : 0.0;
        const Pose pose_a{r.rotation(), Vec3(far, 0, -far)};
        const Pose pose_b{r.rotation(), pose_a.translation + away * r.direction()};
        const CentreTest test = test_centres(a, pose_a, b, pose_b, margin);
        const CentreTest back = test_centres(b, pose_b, a, pose_a, margin);
        REQUIRE(back.verdict == test.verdict);
        REQUIRE(back.normal == -test.normal);
        ++pairs;
        if (test.verdict == CentreTest::Verdict::open) continue;
        const double distance = exact.solve(a, pose_a, b, pose_b, Request::distance).signed_distance;
        if (test.verdict == CentreTest::Verdict::overlapping) {
          ++overlapping;
          REQUIRE(distance < 0);
          continue;
        }
        ++apart;
        const double along = separation(a, pose_a, b, pose_b, test.normal);
        REQUIRE(separation(b, pose_b, a, pose_a, back.normal) == along);
        REQUIRE(along > margin);
        REQUIRE(distance >= along - 1e-10);
        // By so much B comes nearer, and no more than touches.
        Pose near = pose_b;
        near.translation -= along * test.normal;
        REQUIRE(exact.solve(a, pose_a, b, near, Request::distance).signed_distance >= -1e-10);
      }
  CHECK(apart > pairs / 4);
  CHECK(overlapping > pairs / 10);
}

TEST_CASE("centres leave touching balls and rotations askew open") {
  const Shape ball{Sphere{1}}, block{Box{{2, 2, 2}}};
  const Pose origin;
  for (const Shape* s : {&ball, &block}) {
    CHECK(test_centres(*s, origin, ball, Pose::at(2, 0, 0), 0).verdict == CentreTest::Verdict::open);
    CHECK(test_centres(*s, origin, ball, Pose::at(2 + 1e-9, 0, 0), 0).verdict == CentreTest::Verdict::apart);
    CHECK(test_centres(*s, origin, ball, Pose::at(2 - 1e-4, 0, 0), 0).verdict == CentreTest::Verdict::overlapping);
    CHECK(test_centres(*s, origin, ball, Pose::at(2 - 1e-6, 0, 0), 0).verdict == CentreTest::Verdict::open);
    CHECK(test_centres(*s, origin, ball, Pose::at(2.1, 0, 0), 0.2).verdict == CentreTest::Verdict::open);
    CHECK(test_centres(*s, origin, ball, Pose::at(0, 0, 0), 0).verdict == CentreTest::Verdict::overlapping);
  }
}
