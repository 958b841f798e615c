// Minkowski portal refinement.
#include "convex/portal.h"

#include "catch.h"
#include "closed_forms/closed_forms.h"
#include "convex/polytope_portal.h"
#include "pair_classes.h"
#include "random.h"
#include "random_pairs.h"
#include "reference.h"
#include "shapes/hull.h"
#include "shapes/shape_insides.h"

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

TEST_CASE("a portal of polytopes begins near its end: what it tells is right, and next to nothing is left open") {
  using Verdict = PortalResult::Verdict;
  constexpr reference::ShapeRecipe kinds[] = {{ShapeKind::convex, 32},
                                              {ShapeKind::convex, 300},
                                              {ShapeKind::convex, 6},
                                              {ShapeKind::box},
                                              {ShapeKind::triangle}};
  const NarrowPhase exact;
  int pairs = 0, open = 0, found = 0;
  for (const auto& kind_a : kinds)
    for (const auto& kind_b : kinds)
      for (const reference::PairClass pair_class : reference::all_pair_classes)
        for (std::uint64_t i = 0; i < 6; ++i) {
          if (kind_a.kind != ShapeKind::convex && kind_b.kind != ShapeKind::convex) continue;
          const reference::PosedPair p = reference::make_pair(kind_a, kind_b, pair_class, 9100 + i);
          const ConvexView a = view(p.a), b = view(p.b);
          PortalResult portal;
          portal_kernel()({a, b, relative(p.pose_a, p.pose_b)}, portal);
          const reference::Truth truth = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
          INFO(name(kind_a.kind) << kind_a.points << ' ' << name(kind_b.kind) << kind_b.points << ' '
                                 << name(pair_class) << ' ' << i << ": " << truth.signed_distance);
          if (portal.verdict == Verdict::apart) REQUIRE(truth.signed_distance > 0);
          if (portal.verdict == Verdict::overlapping) REQUIRE(truth.signed_distance < 0);
          const PairAnswer answer = exact.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
          REQUIRE(std::abs(answer.signed_distance - truth.signed_distance) <= 1e-14 * reference::size(p));
          SurfaceFace face;
          surface_kernel()({a, b, relative(p.pose_a, p.pose_b)}, 1e-3 * reference::size(p), face);
          // If interior points coincide there is no ray.
          if (pair_class == reference::PairClass::hard || pair_class == reference::PairClass::deep) continue;
          ++pairs;
          if (portal.verdict == Verdict::open) ++open;
          if (face.end != SurfaceFace::End::open) ++found;
        }
  CHECK(open < pairs / 50);
  CHECK(found > pairs * 9 / 10);
}

TEST_CASE("rays leave a hull near the corners that its map names") {
  for (const int points : {5, 32, 300}) {
    const Shape shape =
        reference::make_pair({ShapeKind::convex, points}, {ShapeKind::box}, reference::PairClass::deep, 1).a;
    const Hull& hull = hull_of(shape);
    REQUIRE(!hull.rays.empty());
    reference::Random random(7);
    int hit = 0;
    for (int i = 0; i < 1000; ++i) {
      const Vec3 ray = random.direction();
      const RayMap::Corners& c = hull.rays.corners(ray.x(), ray.y(), ray.z());
      const auto corner = [&](std::size_t k) { return Vec3(hull.vertices[c[k]] - hull.inside); };
      const bool through = corner(0).cross(corner(1)).dot(ray) >= 0 && corner(1).cross(corner(2)).dot(ray) >= 0 &&
                           corner(2).cross(corner(0)).dot(ray) >= 0;
      if (through) ++hit;
    }
    CHECK(hit > 300);
  }
}
