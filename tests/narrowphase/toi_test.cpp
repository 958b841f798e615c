#include <catch2/catch.hpp>
#include <cmath>

#include "random_pairs.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("time of impact: analytic answers") {
  const NarrowPhase n;
  const Shape ball(Sphere{0.5}), plate(Box{{10, 10, 1e-3}}), box(Box{{1, 1, 1}});
  const Vec3 still = Vec3::Zero();
  const auto t = n.time_of_impact(ball, Pose::at(0, 0, 5), Vec3(0, 0, -1000), plate, Pose{}, still, 1);
  REQUIRE(t);
  CHECK(std::abs(*t - (5 - 0.5 - 0.5e-3) / 1000) < 1e-14);
  CHECK_FALSE(n.time_of_impact(ball, Pose::at(0, 0, 5), Vec3(0, 0, 1), plate, Pose{}, still, 100));
  CHECK_FALSE(n.time_of_impact(ball, Pose::at(0, 0, 5), Vec3(0, 0, -1), plate, Pose{}, still, 4.4));
  CHECK(n.time_of_impact(box, Pose{}, still, box, Pose::at(1, 0, 0), Vec3(1, 0, 0), 1) == 0.0);
  const auto end = n.time_of_impact(box, Pose{}, still, box, Pose::at(3, 0, 0), Vec3(-1, 0, 0), 2);
  REQUIRE(end);
  CHECK(std::abs(*end - 2) < 1e-12);
  CHECK_FALSE(n.time_of_impact(box, Pose{}, still, box, Pose::at(3, 0, 0), still, 2));
  CHECK_THROWS_AS(n.time_of_impact(box, Pose{}, still, box, Pose{}, still, -1), std::invalid_argument);
}

TEST_CASE("time of impact: apart before it, touching at it, and never after a sampled touch") {
  Random r(13);
  const NarrowPhase n;
  int hits = 0;
  for (std::size_t ia = 0; ia < shape_kinds; ++ia)
    for (std::size_t ib = 0; ib < shape_kinds; ++ib)
      for (int i = 0; i < 8; ++i) {
        const Shape a = random_shape(static_cast<ShapeKind>(ia), r), b = random_shape(static_cast<ShapeKind>(ib), r);
        if (!n.refuses(a, b, Request::distance).empty()) continue;
        const Pose pa = random_pose(r, 1), pb = random_pose(r, 4);
        const Vec3 va = r.vec(-1, 1), vb = 2 * (pa.translation - pb.translation) + r.vec(-1, 1);
        const auto t = n.time_of_impact(a, pa, va, b, pb, vb, 2);
        CAPTURE(name(a.kind()), name(b.kind()), i);
        const auto at = [&](double time) {
          Pose qa = pa, qb = pb;
          qa.translation += time * va;
          qb.translation += time * vb;
          return n.solve(a, qa, b, qb, Request::distance).signed_distance;
        };
        if (t) {
          CHECK(at(*t) < 1e-8);
          if (*t > 1e-6) CHECK(at(*t * (1 - 1e-6)) > 0);
          ++hits;
        }
        for (int k = 0; k <= 20; ++k) {
          const double time = 0.1 * k;
          if (!t || time < *t - 1e-9) CHECK(at(time) > 0);
        }
      }
  CHECK(hits > 300);
}
