#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "pair_classes.h"
#include "reference.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using reference::PairClass;
using reference::PosedPair;
using reference::ShapeRecipe;

namespace {

constexpr ShapeKind round_kinds[] = {ShapeKind::cylinder, ShapeKind::cone, ShapeKind::ellipsoid};
constexpr ShapeRecipe partners[] = {{ShapeKind::cylinder},   {ShapeKind::cone},    {ShapeKind::ellipsoid},
                                    {ShapeKind::box},        {ShapeKind::capsule}, {ShapeKind::triangle},
                                    {ShapeKind::convex, 24}, {ShapeKind::sphere}};

void check_against_truth(const PosedPair& p) {
  const NarrowPhase solver;
  const reference::Truth truth = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
  const PairAnswer answer = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
  const double size = reference::size(p);
  CAPTURE(name(p.a.kind()), name(p.b.kind()), truth.signed_distance, truth.error, answer.signed_distance);
  if (answer.status == Status::ok)
    CHECK(std::abs(answer.signed_distance - truth.signed_distance) <= 1e-12 * size + truth.error);
  CHECK(std::abs(answer.signed_distance - truth.signed_distance) <= 1e-8 * size + truth.error + answer.error_bound);
  // What is said is what the direction gives: the pair is as far apart along the normal, and so are the points.
  CHECK(std::abs(reference::separation(p.a, p.pose_a, p.b, p.pose_b, answer.normal) - answer.signed_distance) <=
        1e-12 * size);
  CHECK((answer.point_b - answer.point_a - answer.signed_distance * answer.normal).norm() <= 1e-10 * size);
  if (std::abs(truth.signed_distance) > truth.error + 1e-15 * size) {
    const bool touch = truth.signed_distance <= 0;
    CHECK(answer.collide == touch);
    CHECK(solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::collide).collide == touch);
  }
}

}  // namespace

TEST_CASE("round: distance, depth and verdict agree with the certified truth in every class") {
  for (const ShapeKind k : round_kinds)
    for (const ShapeRecipe& partner : partners) {
      if (partner.kind == ShapeKind::sphere && k != ShapeKind::ellipsoid) continue;
      for (const PairClass c : reference::all_pair_classes) {
        CAPTURE(name(c));
        for (std::uint64_t i = 0; i < 6; ++i) check_against_truth(reference::make_pair({k}, partner, c, 5000 + i));
      }
    }
}

TEST_CASE("round: two minima of nearly the same depth are told apart") {
  // The two stand side by side on the sphere of directions in these, or opposite each other.
  const auto pair = [](ShapeKind a, ShapeKind b, std::uint64_t i) {
    return reference::make_pair({a}, {b}, PairClass::deep, i);
  };
  check_against_truth(pair(ShapeKind::cylinder, ShapeKind::cylinder, 30));
  check_against_truth(pair(ShapeKind::cylinder, ShapeKind::cylinder, 167));
  check_against_truth(pair(ShapeKind::triangle, ShapeKind::cylinder, 213));
  check_against_truth(pair(ShapeKind::capsule, ShapeKind::cone, 282));
  check_against_truth(pair(ShapeKind::box, ShapeKind::cone, 89));
  check_against_truth(reference::make_pair({ShapeKind::cone}, {ShapeKind::ellipsoid}, PairClass::hard, 5013));
}

TEST_CASE("round: a warm start, good or bad, changes no more than the last digits") {
  const NarrowPhase solver;
  for (const ShapeKind k : round_kinds)
    for (const PairClass c : {PairClass::separated, PairClass::near, PairClass::shallow})
      for (std::uint64_t i = 0; i < 6; ++i) {
        const PosedPair p = reference::make_pair({k}, {ShapeKind::box}, c, 7000 + i);
        CAPTURE(name(k), name(c), i);
        const PairAnswer cold = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
        WarmStart warm;
        const auto again = [&] {
          const PairAnswer r = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance, nullptr, &warm);
          CHECK(std::abs(r.signed_distance - cold.signed_distance) <= 1e-12 * reference::size(p));
        };
        again();
        CHECK((p.pose_a.rotation * warm.direction - cold.normal).norm() < 1e-6);
        again();
        for (const Vec3& bad : {Vec3(-warm.direction), Vec3(1, 0, 0), Vec3(0, -1e-9, 0)}) {
          warm.direction = bad;
          again();
        }
      }
}

TEST_CASE("round: no minimum between the faces of a hull is lost") {
  const auto check = [](ShapeKind kind, PairClass c, std::uint64_t i) {
    CAPTURE(name(c), i);
    check_against_truth(reference::make_pair({ShapeKind::convex, 32}, {kind}, c, i));
  };
  for (const std::uint64_t i : {3u, 1828u}) check(ShapeKind::cylinder, PairClass::deep, i);
  for (const std::uint64_t i : {153u, 160u, 222u, 286u, 1747u}) check(ShapeKind::cone, PairClass::deep, i);
  // Near a circle of the cone.
  for (const std::uint64_t i : {303u, 644u, 1088u, 1364u}) check(ShapeKind::cone, PairClass::hard, i);
  check(ShapeKind::cone, PairClass::shallow, 868);
  check(ShapeKind::cylinder, PairClass::hard, 1827);
}

TEST_CASE("round: concentric and coaxial shapes have the depth their formulas give") {
  const NarrowPhase solver;
  const auto depth = [&](const Shape& a, const Shape& b, const Pose& pose) {
    const PairAnswer answer = solver.solve(a, Pose{}, b, pose, Request::distance);
    CHECK(answer.status == Status::ok);
    CHECK(std::abs(answer.normal.norm() - 1) < 1e-14);
    return -answer.signed_distance;
  };
  const Shape ball(Ellipsoid{{0.5, 0.5, 0.5}}), rugby(Ellipsoid{{0.3, 0.4, 0.9}});
  CHECK(std::abs(depth(ball, ball, Pose{}) - 1) < 1e-14);
  CHECK(std::abs(depth(rugby, rugby, Pose{}) - 0.6) < 1e-14);
  CHECK(std::abs(depth(rugby, Shape(Sphere{0.2}), Pose{}) - 0.5) < 1e-14);
  CHECK(std::abs(depth(rugby, Shape(Sphere{0}), Pose{}) - 0.3) < 1e-14);
  const Shape can(Cylinder{0.5, 2}), coin(Cylinder{1, 0.01});
  CHECK(std::abs(depth(can, can, Pose{}) - 1) < 1e-14);
  CHECK(std::abs(depth(coin, coin, Pose{}) - 0.01) < 1e-14);
  CHECK(std::abs(depth(can, coin, Pose::at(0, 0, 1)) - 0.005) < 1e-14);
  CHECK(std::abs(depth(can, can, Pose::at(0, 0, 2 + 1e-9)) + 1e-9) < 1e-14);
  CHECK(std::abs(depth(can, can, Pose::at(1 + 1e-9, 0, 0.3)) + 1e-9) < 1e-14);
  const Shape cone(Cone{0.5, 1});
  // The apex of one is in the base of the other.
  CHECK(std::abs(depth(cone, cone, Pose::at(0, 0, 1 - 1e-3)) - 1e-3) < 1e-14);
  CHECK(std::abs(depth(cone, can, Pose::at(0, 0, 1.5 - 1e-6)) - 1e-6) < 1e-14);
}

TEST_CASE("round: a common motion and the order of arguments change nothing beyond rounding") {
  const NarrowPhase solver;
  for (const ShapeKind k : round_kinds)
    for (const ShapeRecipe& partner : partners) {
      if (partner.kind == ShapeKind::sphere && k != ShapeKind::ellipsoid) continue;
      for (const PairClass c : {PairClass::separated, PairClass::near, PairClass::shallow, PairClass::deep})
        for (std::uint64_t i = 0; i < 4; ++i) {
          const PosedPair p = reference::make_pair({k}, partner, c, 7000 + i);
          CAPTURE(name(k), name(partner.kind), name(c), i);
          const double tolerance = 1e-13 * reference::size(p);
          const double here = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance).signed_distance;
          const PairAnswer swapped = solver.solve(p.b, p.pose_b, p.a, p.pose_a, Request::distance);
          CHECK(std::abs(swapped.signed_distance - here) <= tolerance);
          const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(0.36, -0.48, 0.8)).toRotationMatrix();
          const Pose a{turn * p.pose_a.rotation, turn * p.pose_a.translation};
          const Pose b{turn * p.pose_b.rotation, turn * p.pose_b.translation};
          CHECK(std::abs(solver.solve(p.a, a, p.b, b, Request::distance).signed_distance - here) <= 10 * tolerance);
        }
    }
}
