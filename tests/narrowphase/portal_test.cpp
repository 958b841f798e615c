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
