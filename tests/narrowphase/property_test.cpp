// Every convex kind with every other in five classes of poses, compared with the reference and with invariants: under a
// rigid motion, another order of a hull's points, a small step along a slide.
#include <cmath>
#include <utility>
#include <vector>

#include "catch.h"
#include "judge.h"
#include "random.h"
#include "shapes/shape_insides.h"

using namespace tandem;
using namespace tandem::test;
using reference::all_pair_classes;
using reference::make_pair;
using reference::PairClass;
using reference::PosedPair;
using reference::Random;
using reference::ShapeRecipe;
using reference::Truth;

namespace {

constexpr ShapeRecipe kinds[] = {{ShapeKind::sphere},   {ShapeKind::box},       {ShapeKind::capsule},
                                 {ShapeKind::cylinder}, {ShapeKind::cone},      {ShapeKind::ellipsoid},
                                 {ShapeKind::convex},   {ShapeKind::halfspace}, {ShapeKind::triangle}};

/// Each pair of kinds once in the given order, without two half-spaces.
template <class Check>
void for_each_pair(std::uint64_t poses, Check&& check) {
  for (std::size_t i = 0; i < std::size(kinds); ++i)
    for (std::size_t j = i; j < std::size(kinds); ++j)
      for (const PairClass c : all_pair_classes) {
        if (kinds[i].kind == ShapeKind::halfspace && kinds[j].kind == ShapeKind::halfspace) continue;
        // The hard class has twelve subclasses: a few of each for a pair of kinds.
        const std::uint64_t first = c == PairClass::hard ? 5 * i + 7 * j : 0;
        for (std::uint64_t k = first; k < first + poses; ++k) check(make_pair(kinds[i], kinds[j], c, k));
      }
}

double distance(const NarrowPhase& solver, const PosedPair& p) {
  return solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance).signed_distance;
}

double distance_bound(const PosedPair& p) { return accepted(p.a, p.b).distance * reference::size(p) + 4 * rounding(p); }

}  // namespace

TEST_CASE("property: every kind with every kind is as the reference says, whichever comes first") {
  const NarrowPhase solver;
  int judged = 0, inexact = 0;
  for_each_pair(4, [&](const PosedPair& p) {
    const Truth truth = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
    const std::string wrong = judge(solver, p, truth);
    if (!wrong.empty()) FAIL_CHECK(wrong << record(p));
    ++judged;
    if (solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance).status == Status::inexact) ++inexact;
  });
  CHECK(judged == 44 * 5 * 4);
  CHECK(inexact == 0);
}

TEST_CASE("property: a rigid motion of both changes nothing") {
  const NarrowPhase solver;
  Random r(1);
  for_each_pair(3, [&](const PosedPair& p) {
    const Mat3 turn = r.rotation();
    const Vec3 shift = r.vec(-3, 3);
    PosedPair q = p;
    q.pose_a = {turn * p.pose_a.rotation, turn * p.pose_a.translation + shift};
    q.pose_b = {turn * p.pose_b.rotation, turn * p.pose_b.translation + shift};
    const double found = distance(solver, q), before = distance(solver, p);
    // The motion's rounding moves the shapes: by that much, and twice for two shapes.
    if (!(std::abs(found - before) <= 2 * distance_bound(p) + 8 * rounding(q)))
      FAIL_CHECK("moved " << found << " for " << before << ' ' << record(p));
  });
}

TEST_CASE("property: the order of a hull's points changes nothing") {
  const NarrowPhase solver;
  Random r(2);
  for (const ShapeRecipe& other : kinds)
    for (const PairClass c : all_pair_classes)
      for (std::uint64_t k = 0; k < 6; ++k) {
        const PosedPair p = make_pair({ShapeKind::convex}, other, c, k);
        Convex shuffled{hull_of(p.a).vertices};
        for (std::size_t i = shuffled.vertices.size(); i > 1; --i)
          std::swap(shuffled.vertices[i - 1],
                    shuffled.vertices[static_cast<std::size_t>(r.below(static_cast<int>(i)))]);
        const PosedPair q{Shape(shuffled), p.pose_a, p.b, p.pose_b};
        const PairAnswer x = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
        const PairAnswer y = solver.solve(q.a, q.pose_a, q.b, q.pose_b, Request::distance);
        if (!(std::abs(x.signed_distance - y.signed_distance) <= distance_bound(p)))
          FAIL_CHECK("shuffled " << y.signed_distance << " for " << x.signed_distance << ' ' << record(p));
        if (x.collide != y.collide && std::abs(x.signed_distance) > 1e-15 * reference::size(p))
          FAIL_CHECK("another verdict " << record(p));
      }
}

TEST_CASE("property: the depth along the normal separates, less of it does not") {
  const NarrowPhase solver;
  for_each_pair(3, [&](const PosedPair& p) {
    const PairAnswer r = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
    const double depth = -r.signed_distance;
    if (!(depth > 1e-9 * reference::size(p) + 1000 * rounding(p))) return;
    PosedPair q = p;
    const auto collides_at = [&](double share) {
      q.pose_b.translation = p.pose_b.translation + share * depth * r.normal;
      return solver.solve(q.a, q.pose_a, q.b, q.pose_b, Request::collide).collide;
    };
    if (collides_at(1.01)) FAIL_CHECK("1.01 x depth along the normal does not separate " << record(p));
    if (!collides_at(0.99)) FAIL_CHECK("0.99 x depth along the normal separates " << record(p));
  });
}

TEST_CASE("property: the signed distance follows a slide without a jump") {
  const NarrowPhase solver;
  Random r(3);
  for (const ShapeRecipe& a : kinds)
    for (const ShapeRecipe& b : kinds) {
      if (a.kind == ShapeKind::halfspace && b.kind == ShapeKind::halfspace) continue;
      PosedPair p = make_pair(a, b, PairClass::deep, 3);
      const Vec3 start = p.pose_b.translation, heading = r.direction();
      double before = 0;
      constexpr int steps = 60;
      for (int i = 0; i <= steps; ++i) {
        const double s = -2 + 4.0 * i / steps;
        p.pose_b.translation = start + s * heading;
        const double now = distance(solver, p);
        // A step changes the distance by at most the step.
        if (i > 0 && !(std::abs(now - before) <= 4.0 / steps + 2 * distance_bound(p)))
          FAIL_CHECK("a step of " << 4.0 / steps << " from " << before << " to " << now << ' ' << record(p));
        before = now;
      }
    }
}
