// Quick tests of pairs by the line of centres.
#include "pairs/centre_test.h"

#include "catch.h"
#include "mesh_samples.h"
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
        REQUIRE(back.between == -test.between);
        ++pairs;
        if (test.verdict == CentreTest::Verdict::open) continue;
        const double distance = exact.solve(a, pose_a, b, pose_b, Request::distance).signed_distance;
        if (test.verdict == CentreTest::Verdict::overlapping) {
          ++overlapping;
          REQUIRE(distance < 0);
          continue;
        }
        ++apart;
        const Vec3 n = test.between.normalized();
        const double along = separation(a, pose_a, b, pose_b, n);
        REQUIRE(separation(b, pose_b, a, pose_a, -n) == along);
        REQUIRE(along > margin);
        REQUIRE(distance >= along - 1e-10);
        // Moves B nearer by the margin found, to contact at most.
        Pose near = pose_b;
        near.translation -= along * n;
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

TEST_CASE("hulls of meshes that are apart: never farther than the meshes are, the same from both sides") {
  Random r(78);
  const NarrowPhase exact;
  int known = 0, apart = 0;
  const Shape triangle{Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.3, 1, 0)}}};
  for (const Shape& a : {Shape(torus(1, 0.4, 24, 12)), triangle})
    for (const Shape& b : {Shape(torus(0.6, 0.2, 12, 8)), Shape(torus(50, 1, 24, 8))})
      for (int i = 0; i < 100; ++i) {
        const double far = i % 5 == 0 ? 1e5 : 0.0;
        const Pose pose_a{r.rotation(), Vec3(far, 0, -far)};
        Pose pose_b{r.rotation(), pose_a.translation + b.size() * r.vec_of_length(0, 1.2)};
        // Points are those of R v + t, also for rotations of six decimals.
        if (i % 2 == 0) pose_b.rotation = (pose_b.rotation * 1e6).array().round() / 1e6;
        const MeshGap gap = test_hulls(a, pose_a, b, pose_b), back = test_hulls(b, pose_b, a, pose_a);
        REQUIRE(back.at_least == gap.at_least);
        REQUIRE(back.normal == -gap.normal);
        const PairAnswer truth = exact.solve(a, pose_a, b, pose_b, Request::distance);
        apart += truth.signed_distance > 0 ? 1 : 0;
        if (gap.at_least == 0) continue;
        ++known;
        REQUIRE(truth.signed_distance >= gap.at_least);
        REQUIRE(gap.normal.dot(truth.point_b - truth.point_a) >= gap.at_least - 1e-9 * b.size());
        // Moves B nearer by the bound found; they are still separated or just touch.
        Pose near = pose_b;
        near.translation -= 0.999 * gap.at_least * gap.normal;
        REQUIRE_FALSE(exact.solve(a, pose_a, b, near, Request::collide).collide);
      }
  CHECK(known > apart / 2);
}

TEST_CASE("hulls of meshes that are nearer than single precision tells leave it open") {
  const Shape block(box_mesh({2, 2, 2}));
  const Pose origin;
  CHECK(test_hulls(block, origin, block, Pose::at(2 + 1e-5, 0, 0)).at_least > 0);
  CHECK(test_hulls(block, origin, block, Pose::at(2 + 1e-9, 0, 0)).at_least == 0);
  CHECK(test_hulls(block, origin, block, Pose::at(2, 0, 0)).at_least == 0);
  CHECK(test_hulls(block, origin, block, origin).at_least == 0);
}

TEST_CASE("the line between a mesh's hull and a convex shape tells no more than their distance") {
  Random r(78);
  const NarrowPhase exact;
  const Shape mesh{torus(0.8, 0.3, 24, 12)};
  int apart = 0, near = 0, pairs = 0;
  for (const ShapeKind kind : bounded_convex)
    for (int i = 0; i < 60; ++i) {
      const Shape convex = random_shape(kind, r);
      const double far = i % 5 == 0 ? 1e5 : 0.0;
      const Pose pose_mesh{r.rotation(), Vec3(far, 0, -far)};
      const Pose pose_convex{r.rotation(), pose_mesh.translation + r.vec_of_length(0, 4)};
      const double gap = test_hull(mesh, pose_mesh, convex, pose_convex);
      const PairAnswer answer = exact.solve(mesh, pose_mesh, convex, pose_convex, Request::distance);
      CAPTURE(kind, i, gap);
      REQUIRE(gap >= 0);
      ++pairs;
      if (gap == 0) continue;
      ++apart;
      REQUIRE(answer.signed_distance >= gap);
      near += gap < 0.1 ? 1 : 0;
      CHECK(!exact.solve(mesh, pose_mesh, convex, pose_convex, Request::collide).collide);
    }
  CHECK(apart > pairs / 4);
  CHECK(near > 5);
}
