#include "portal.h"

#include <catch2/catch.hpp>

#include "closed_forms.h"
#include "pair_classes.h"
#include "random_pairs.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("a portal tells what the distance tells, and leaves little open that is not close to touching") {
  using Verdict = PortalResult::Verdict;
  const NarrowPhase exact;
  int pairs = 0, clear = 0, open = 0;
  for (const ShapeKind kind_a : bounded_convex)
    for (const ShapeKind kind_b : bounded_convex)
      for (const reference::PairClass pair_class : reference::all_pair_classes)
        for (std::uint64_t i = 0; i < 12; ++i) {
          const reference::PosedPair p = reference::make_pair({kind_a}, {kind_b}, pair_class, 9000 + i);
          const ConvexView a = view(p.a), b = view(p.b);
          const PortalResult portal = search_portal({a, b, relative(p.pose_a, p.pose_b)});
          const double distance =
              exact.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance).signed_distance / reference::size(p);
          INFO(name(kind_a) << ' ' << name(kind_b) << ' ' << name(pair_class) << ' ' << i << ": " << distance);
          if (portal.verdict == Verdict::apart) REQUIRE(distance > 0);
          if (portal.verdict == Verdict::overlapping) REQUIRE(distance < 0);
          const bool solid = kind_a != ShapeKind::triangle && kind_b != ShapeKind::triangle;
          if (pair_class == reference::PairClass::hard || !solid) continue;
          ++pairs;
          if (std::abs(distance) < 1e-2) continue;
          ++clear;
          if (portal.verdict == Verdict::open) ++open;
        }
  CHECK(clear > pairs / 4);
  CHECK(open < clear / 50);
}

TEST_CASE("points are moved into a shape, and stay where they are well inside") {
  Random r(5);
  int stayed = 0, moved = 0;
  for (const ShapeKind kind : {ShapeKind::box, ShapeKind::cylinder, ShapeKind::cone})
    for (int i = 0; i < 2000; ++i) {
      const Shape shape = random_shape(kind, r);
      const ConvexView core = view(shape);
      const double least = i % 2 == 0 ? 1e-12 : 0.05;
      const Vec3 p = r.vec(-1.2, 1.2);
      Vec3 q = p;
      const PointDistance before = point_distance(core, p);
      const bool inside = move_into(core, q, least);
      if (inside) {
        ++stayed;
        REQUIRE(q == p);
        REQUIRE(before.signed_distance < -least);
        continue;
      }
      ++moved;
      REQUIRE(before.signed_distance > -2 * least);
      REQUIRE(point_distance(core, q).signed_distance <= 1e-15);
      REQUIRE((q - p).norm() == Approx(std::max(0.0, before.signed_distance)).margin(1e-14));
    }
  CHECK(stayed > 100);
  CHECK(moved > 500);
  const Shape ball{Ellipsoid{{1, 1, 1}}};
  Vec3 out{3, 0, 4}, in{0.3, 0, 0.4};
  CHECK_FALSE(move_into(view(ball), out, 0.1));
  CHECK((out - Vec3(0.6, 0, 0.8)).norm() < 1e-15);
  CHECK(move_into(view(ball), in, 0.4));
  CHECK_FALSE(move_into(view(ball), in, 0.6));
}
