// Cylinders, cones and ellipsoids.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "catch.h"
#include "judge.h"
#include "pair_classes.h"
#include "random.h"
#include "reference.h"
#include "shapes/support.h"
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

Mat3 turned(const std::array<double, 9>& rows) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rows.data());
}

void check_against_truth(const PosedPair& p) {
  const NarrowPhase solver;
  const reference::Truth truth = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
  const PairAnswer answer = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
  const double size = reference::size(p);
  CAPTURE(name(p.a.kind()), name(p.b.kind()), truth.signed_distance, truth.error, answer.signed_distance);
  if (answer.status == Status::ok)
    CHECK(std::abs(answer.signed_distance - truth.signed_distance) <= 1e-12 * size + truth.error);
  CHECK(std::abs(answer.signed_distance - truth.signed_distance) <= 1e-8 * size + truth.error + answer.error_bound);
  // The answer agrees with its direction: the separation along the normal is the distance, and so is that of the
  // points.
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
  // In these the two minima are close together on the sphere of directions, or opposite to each other.
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

TEST_CASE("round: an apex hardly over a rim is parted from it along the cone's side") {
  // The minimum is 1e-4 wide on the circle of the lateral normals, and 7 % below the one on the cylinder's axis.
  const Pose pose_a{
      (Mat3() << 0.62032530633321126, 0.022049166408113743, -0.78403466032013847, 0.06487953079176291,
       -0.99762159391659977, 0.023276637118451914, -0.78165667706919018, -0.065306887936960475, -0.62028046042184926)
          .finished(),
      {0.029649341314982536, -0.086740101421014695, -0.091375574639496374}};
  const Pose pose_b{
      (Mat3() << 0.18853644139752901, 0.80386567507654938, 0.56414004174396259, -0.92707546905380589,
       -0.043842010649357777, 0.3723022331129478, 0.3240140196717145, -0.59319293196728617, 0.73697833110630362)
          .finished(),
      {-0.31147216205926681, -0.78144617985614884, -0.22285250478753818}};
  const Shape cone(Cone{0.37908402793479745, 0.37896766689883155}),
      cylinder(Cylinder{0.61826610103390567, 0.75837917630378193});
  check_against_truth({cone, pose_a, cylinder, pose_b});
  const PairAnswer r = NarrowPhase().solve(cone, pose_a, cylinder, pose_b, Request::distance);
  CHECK(std::abs(r.signed_distance + 3.2211999857e-8) < 1e-16);
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
  // A descent from the least direction itself led uphill.
  check_against_truth(reference::make_pair({ShapeKind::cone}, {ShapeKind::convex, 256}, PairClass::hard, 90003));
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

namespace {

void check_by_judge(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  const NarrowPhase solver;
  const PosedPair p{a, pose_a, b, pose_b};
  const std::string wrong = test::judge(solver, p, reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b));
  if (!wrong.empty()) FAIL_CHECK(wrong << test::record(p));
}

Mat3 tilt(double x, double y, double z) { return Quat(1, x, y, z).normalized().toRotationMatrix(); }

/// Needles, discs, flat cones, blades: proportions of 1 to 1e4.
Shape thin_shape(reference::Random& r, ShapeKind kind) {
  const auto length = [&] {
    const double lengths[] = {1, 0.5, 3, 0.01, 1e-4, r.in(0.1, 1), r.power_of_two(-12, 1)};
    return lengths[r.below(7)];
  };
  const auto point = [&] {
    const auto coordinate = [&] { return r.once_in(3) ? 0.0 : r.sign() * length(); };
    const double x = coordinate(), y = coordinate();
    return Vec3(x, y, coordinate());
  };
  const double x = length(), y = length();
  switch (kind) {
    case ShapeKind::box:
      return Shape(Box{{x, y, length()}});
    case ShapeKind::capsule:
      return Shape(Capsule{x, r.once_in(3) ? 1e-11 * y : y});
    case ShapeKind::cylinder:
      return Shape(Cylinder{x, y});
    case ShapeKind::cone:
      return Shape(Cone{x, y});
    case ShapeKind::ellipsoid:
      return Shape(Ellipsoid{{x, y, length()}});
    case ShapeKind::triangle:
      return Shape(Triangle{{point(), point(), point()}});
    case ShapeKind::convex: {
      Convex hull;
      for (int points = 1 + r.below(7); points > 0; --points) hull.vertices.push_back(point());
      return Shape(hull);
    }
    default:
      return Shape(Sphere{x});
  }
}

/// Aligned, quarter turns, slightly tilted or arbitrary.
Mat3 random_turn(reference::Random& r) {
  const Mat3 quarter = (Mat3() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished();
  switch (r.below(5)) {
    case 0:
      return Mat3::Identity();
    case 1:
      return r.once_in(2) ? quarter : Mat3(quarter * quarter);
    case 2:
      return r.rotation();
    default: {
      const double angle = std::ldexp(1.0, -15 - r.below(38));
      const Vec3 v = angle * r.direction();
      const Mat3 tilted = tilt(v.x(), v.y(), v.z());
      return r.once_in(2) ? tilted : Mat3(tilted * quarter);
    }
  }
}

}  // namespace

TEST_CASE("round: axes that are parallel to the last digits") {
  // The two circles of directions perpendicular to the axes intersect where rounding decides, and every direction on
  // one is equally good.
  const Shape can(Cylinder{0.3, 1}), tin(Cylinder{0.3, 0.25}), coin(Cylinder{1.5, 0.015}), needle(Capsule{0.18, 64}),
      pill(Capsule{0.1, 1}), dot(Capsule{0.3, 3e-12}), cone(Cone{0.5, 1});
  const NarrowPhase solver;
  const auto check = [&](const Shape& a, const Shape& b, const Vec3& t) {
    const auto solve = [&](double angle) {
      const Pose pose{tilt(0.6 * angle, -0.3 * angle, 0.1 * angle), t};
      const PairAnswer r = solver.solve(a, {}, b, pose, Request::distance);
      const double size = std::max(a.size(), b.size());
      CHECK(std::abs(reference::separation(a, {}, b, pose, r.normal) - r.signed_distance) <= 1e-14 * size);
      CHECK((r.point_b - r.point_a - r.signed_distance * r.normal).norm() <= 1e-9 * size);
      return r.signed_distance;
    };
    const double parallel = solve(0);
    for (const double angle : {1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-14})
      CHECK(std::abs(solve(angle) - parallel) <= 2 * angle * (a.size() + b.size()) + 1e-14);
  };
  for (const Vec3& t : {Vec3(0, 0, 0), Vec3(0.25, 0, 0.1), Vec3(0.8, 0, 0)})
    for (const Shape* b : {&can, &tin, &coin, &needle, &pill, &dot, &cone})
      for (const Shape* a : {&can, &coin, &cone}) check(*a, *b, t);
}

TEST_CASE("round: a stretched ellipsoid has no minimum too narrow to find") {
  // 30 : 5, 1 : 167 and 1 : 1800.
  check_by_judge(Shape(Ellipsoid{{3.1, 0.5, 2}}), {}, Shape(Cylinder{0.0427, 0.0085}),
                 {Quat(0.33, -0.06, -0.16, -0.93).normalized().toRotationMatrix(), {-0.375, 0, 0}});
  const Quat disc(0.4, 0.57, -0.826, 0.136);
  check_by_judge(Shape(Ellipsoid{{1.5, 0.009, 1.5}}), Pose{disc.normalized().toRotationMatrix(), {0.1, 0, -0.0027}},
                 Shape(Box{{0.3, 3, 0.3}}), Pose::at(0.2, 0, 0.0414));
  const Mat3 turned = (Mat3() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished();
  check_by_judge(Shape(Ellipsoid{{0.3, 150, 0.083}}), {}, Shape(Cylinder{6.98, 0.25}), {turned, {0, 156.82, 0}});
}

TEST_CASE("round: of the two faces of a polytope at an edge that the origin is on, one is searched") {
  // Concentric: every point of the difference has its opposite, and the first two vertices have the origin between
  // them.
  Pose pose;
  pose.rotation << -0.37733555570648569, -0.89575898999261372, -0.2350185317099269, -0.83103165662257883,
      0.21553548841213388, 0.51276782165622969, -0.40866155200949539, 0.38879337067696434, -0.825733280682591;
  const PairAnswer r = NarrowPhase().solve(
      Shape(Ellipsoid{{0.34161430732297388, 0.65046822951416905, 0.66394447279761482}}), {},
      Shape(Ellipsoid{{0.60978274204198524, 0.28389302440756187, 0.0013736884503447815}}), pose, Request::distance);
  CHECK(r.signed_distance == Approx(-0.64700367049).epsilon(1e-11));
}

TEST_CASE("round: a small shape deep in a large one is known to rounding") {
  // Every direction perpendicular to the large one's axis is equally good to a ten-thousandth.
  const NarrowPhase solver;
  reference::Random r(3);
  const Shape big(Cylinder{37.5, 97}), tall(Cone{33.6, 101});
  for (const Shape& small : {Shape(Cylinder{0.0036, 0.0115}), Shape(Box{{0.0057, 0.0049, 0.0077}}),
                             Shape(Capsule{0.0044, 0.0067}), Shape(Cone{0.005, 0.01})})
    for (const Shape* large : {&big, &tall})
      for (int i = 0; i < 10; ++i) {
        const Pose pose{r.rotation(), r.vec(-1e-3, 1e-3)};
        const PairAnswer answer = solver.solve(*large, {}, small, pose, Request::distance);
        CHECK(answer.status == Status::ok);
        // A bound by points of the small one: the centre's depth and its extent.
        const double centre = solver.solve(*large, {}, Shape(Sphere{0}), pose, Request::distance).signed_distance;
        CHECK(answer.signed_distance < centre);
        CHECK(answer.signed_distance >= centre - small.size());
        for (int k = 0; k < 200; ++k) {
          const Vec3 n = k % 2 == 0 ? r.direction() : Vec3{r.in(-1, 1), r.in(-1, 1), 0};
          CHECK(reference::separation(*large, {}, small, pose, n) <= answer.signed_distance + 1e-14 * large->size());
        }
      }
}

TEST_CASE("round: discs, segments and triangles through flat cones") {
  const Shape disc(Cone{14.4, 2.6e-9}), flat(Cone{4.8, 0.5}), cone(Cone{3.6, 3.6}), plate(Cone{1, 1e-4}),
      tent(Cone{41, 1.5});
  const Shape segment(Convex{{{1, 0.005, 0}, {0, 0, 0}}}), line(Convex{{{-1, 0, 0}, {1, 0, 0}}}),
      box(Box{{0.25, 0.08, 0.5}}), blade(Triangle{{Vec3(0.8, -96, 0), Vec3(-0.003, 0, 0), Vec3(1, 0, -0.0025)}}),
      seed(Capsule{0.1, 0.023});
  reference::Random r(5);
  for (const Shape* a : {&disc, &flat, &plate, &tent})
    for (const Shape* b : {&segment, &line, &cone, &box, &blade, &seed})
      for (const double height : {0.0, 0.2367})
        for (int i = 0; i < 2; ++i) {
          const Mat3 turned = i == 0 ? Mat3(Mat3::Identity()) : height > 0 ? tilt(1e-7, -2e-7, 0) : r.rotation();
          check_by_judge(*a, {}, *b, {turned, {0.11, -0.07, height}});
        }
}

TEST_CASE("round: thin shapes of every kind, touching, tilted and concentric, are answered as well as plump ones") {
  constexpr ShapeKind others[] = {ShapeKind::box,       ShapeKind::capsule,  ShapeKind::cylinder, ShapeKind::cone,
                                  ShapeKind::ellipsoid, ShapeKind::triangle, ShapeKind::convex,   ShapeKind::sphere};
  reference::Random r(77);
  for (int i = 0; i < 150; ++i) {
    const Shape a = thin_shape(r, round_kinds[i % 3]), b = thin_shape(r, others[r.below(8)]);
    Pose pose_b{random_turn(r), Vec3::Zero()};
    if (!r.once_in(4)) {
      const Bounds box_a = a.bounds({}), box_b = b.bounds(pose_b);
      const int k = r.below(3);
      const double hairs[] = {0, 1e-12, -1e-12, 1e-8, -1e-8, 1e-3, -1e-3, -0.3, -0.5};
      const double reach = box_a.hi[k] - box_b.lo[k];
      pose_b.translation[k] = reach * (1 + hairs[r.below(9)]);
      if (r.once_in(2)) pose_b.translation[(k + 1) % 3] = reach * r.in(-0.5, 0.5);
    }
    const Pose world = r.once_in(2) ? Pose{} : Pose{r.rotation(), r.vec(-3, 3)};
    check_by_judge(a, world, b, {world.rotation * pose_b.rotation, world * pose_b.translation});
  }
}

TEST_CASE("round: almost the same all around, they are solved to the end") {
  const NarrowPhase solver;
  reference::Random r(63);
  // The reference takes seconds if all directions around are alike: only a few hundred of these.
  const auto check = [&](const PosedPair& p) {
    const PairAnswer answer = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
    CHECK(answer.status == Status::ok);
    const auto along = [&](const Vec3& n) { return reference::separation(p.a, p.pose_a, p.b, p.pose_b, n); };
    const double slack = 1e-10 * reference::size(p);
    CHECK(std::abs(along(answer.normal) - answer.signed_distance) <= slack);
    double most = -1e9;
    for (const Pose* pose : {&p.pose_a, &p.pose_b})
      for (int k = 0; k < 100; ++k) {
        const Mat3 turn = Eigen::AngleAxisd(0.02 * M_PI * k, pose->rotation.col(2)).toRotationMatrix();
        most = std::max(most, along(turn * answer.normal));
        most = std::max(most, along(turn * any_perpendicular(pose->rotation.col(2))));
      }
    CHECK(most <= answer.signed_distance + slack);
  };
  // Concentric and coaxial, or almost.
  const Shape shapes[] = {Cylinder{0.5, 0.8}, Cylinder{0.3, 1.4}, Cone{0.5, 0.9}, Cone{0.7, 0.4}};
  for (const Shape& a : shapes)
    for (const Shape& b : shapes)
      for (const double off : {0.0, 1e-12, 1e-9, 1e-3})
        for (const double tilt : {0.0, 1e-9, 1e-6, 1e-3}) {
          if (r.unit() > 0.3) continue;
          const Pose pose_a{r.rotation(), r.vec(-1, 1)};
          const Mat3 turn = Eigen::AngleAxisd(tilt, r.direction()).toRotationMatrix();
          CAPTURE(name(a.kind()), name(b.kind()), off, tilt);
          check({a, pose_a, b, {turn * pose_a.rotation, pose_a.translation + off * r.direction()}});
        }
  // And beside balls.
  for (const ShapeKind k : {ShapeKind::capsule, ShapeKind::cylinder, ShapeKind::cone, ShapeKind::ellipsoid})
    for (int i = 0; i < 8; ++i) {
      const Shape a = k == ShapeKind::capsule    ? Shape(Capsule{0.3, 0.8})
                      : k == ShapeKind::cylinder ? shapes[0]
                      : k == ShapeKind::cone     ? shapes[2]
                                                 : Shape(Ellipsoid{{0.3, 0.31, 0.7}});
      const Shape b(Ellipsoid{Vec3(0.9, 0.9, 0.9) + std::pow(10.0, -2 - i % 4) * r.vec(-1, 1)});
      const Pose pose_a{r.rotation(), r.vec(-1, 1)};
      CAPTURE(name(k), i);
      check({a, pose_a, b, {r.rotation(), pose_a.translation + (i % 2) * 1e-3 * r.direction()}});
    }
}

TEST_CASE("round: a hull far from its own origin has points as exact as another") {
  // A point beside a cone, both 59 from the point's frame.
  const Shape point(Convex{{Vec3(-0.3, 59.084710754600778, 0.25)}}), cone(Cone{0.0060625814255629495, 0.3});
  const Pose turned{Eigen::AngleAxisd(3e-7, Vec3(0.9, 0.3, -0.3).normalized()).toRotationMatrix(), {0, 0, 0.28}};
  const PosedPair pair{point, Pose{}, cone, turned};
  CHECK(test::judge(NarrowPhase(), pair, reference::signed_distance(point, Pose{}, cone, turned)) == "");
  reference::Random r(64);
  for (int i = 0; i < 6; ++i) {
    Convex far;
    for (int k = 0; k < 12; ++k) far.vertices.push_back(Vec3(300, -700, 200) + 0.5 * r.direction());
    const Pose here{r.rotation(), Vec3::Zero()};
    const Pose back{Mat3::Identity(), r.vec(-1, 1) - Vec3(300, -700, 200)};
    const PosedPair p{Shape(far), back, i % 2 == 0 ? cone : Shape(Cylinder{0.4, 0.6}), here};
    CHECK(test::judge(NarrowPhase(), p, reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b)) == "");
  }
}

TEST_CASE("round: gjk by its name has the last digits too, a hair apart and deep") {
  const NarrowPhase solver, gjk({.tolerance = 0, .margin = 0, .solver = "gjk"});
  reference::Random r(65);
  for (const ShapeRecipe& a : partners)
    for (const ShapeKind k : round_kinds)
      for (int i = 0; i < 10; ++i) {
        PosedPair p = reference::make_pair(a, {k}, reference::all_pair_classes[static_cast<std::size_t>(i % 4)],
                                           9000 + static_cast<std::uint64_t>(i));
        PairAnswer truth = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
        if (i % 2 == 0) {
          const double gap = std::pow(10.0, -r.in(3, 13)) * (i % 4 == 0 ? 1 : -1);
          p.pose_b.translation += (gap - truth.signed_distance) * truth.normal;
          truth = solver.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
        }
        const PairAnswer found = gjk.solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance);
        CAPTURE(name(p.a.kind()), name(k), i, truth.signed_distance, found.error_bound);
        // From inside it may have found another minimum than the least, and then reports that.
        CHECK(std::abs(found.signed_distance - truth.signed_distance) <=
              1e-12 * reference::size(p) + (truth.signed_distance < 0 ? found.error_bound + truth.error_bound : 0));
      }
}

TEST_CASE("round: balls inside ellipsoids of any length, on the axis, beside it and at the centre") {
  const NarrowPhase solver;
  reference::Random r(66);
  for (const double length : {1.5, 5.0, 100.0, 1e4})
    for (const double radius : {0.0, 0.3, 20.0})
      for (const double part : {0.0, 1e-12, 0.3, 0.9})
        for (int axis = 0; axis < 3; ++axis)
          for (const double beside : {0.0, 1e-15, 1e-4}) {
            const double at = part * (length - 1 / length);  // so far in, the nearest point is not the tip
            Vec3 radii = Vec3::Ones(), centre = beside * r.direction();
            radii[axis] = length;
            centre[axis] = at;
            const Mat3 turn = r.rotation();
            const Pose pose{turn, Vec3::Zero()}, there{Mat3::Identity(), turn * centre};
            const Shape ellipsoid = Ellipsoid{radii}, ball = Sphere{radius};
            const PairAnswer one = solver.solve(ellipsoid, pose, ball, there, Request::distance);
            const PairAnswer other = solver.solve(ball, there, ellipsoid, pose, Request::distance);
            const Shape corner = Triangle{{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}};
            const PairAnswer point = solver.solve(ellipsoid, pose, corner, there, Request::distance);
            CAPTURE(length, radius, part, axis, beside);
            CHECK(std::abs(point.signed_distance - radius - one.signed_distance) < 1e-13 * (length + radius));
            for (const PairAnswer& found : {one, other, point}) {
              CHECK(found.status == Status::ok);
              CHECK(found.error_bound < 1e-13 * length);
            }
            CHECK(std::abs(one.signed_distance - other.signed_distance) < 1e-15 * (length + radius));
            // From a point on the long axis.
            const double depth = radius + std::sqrt(1 - at * at / (length * length - 1));
            const double nearer = beside * std::sqrt(1 + 1 / length);
            CHECK(-one.signed_distance < depth + 1e-14 * length);
            CHECK(-one.signed_distance > depth - nearer - 1e-14 * length);
            if (beside > 0.01 / length) continue;
            const Vec3 side = turn.transpose() * one.normal;
            CHECK(std::abs(side[axis] - at / (length * length - 1) / (depth - radius)) < 1e-3);
          }
}

TEST_CASE("round: a small triangle over a disc's rim is as far from its point as it says, and behind its plane") {
  // The last digits of the normal decide between points along the rim, and between corners of the triangle.
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    CAPTURE(seed);
    reference::Random r(61000 + seed);
    const double radius = r.in(0.1, 1), length = r.in(0.1, 1), gap = r.once_in(3) ? std::pow(10, -r.in(0, 8)) : 0.5;
    const Shape a = r.once_in(2) ? Shape(Cone{radius, length}) : Shape(Cylinder{radius, length});
    const Pose pose_a{r.rotation(), Vec3::Zero()};
    const double angle = r.in(0, 2 * std::numbers::pi),
                 off = r.once_in(8) ? 0 : r.in(-1, 1) * std::pow(10, -r.in(0, 17));
    const Vec3 over{(radius + off) * std::cos(angle), (radius + off) * std::sin(angle), -length / 2 - gap};
    const double size = std::pow(10, -r.in(0, 9));
    Triangle t;
    for (Vec3& corner : t.vertices) {
      const double x = r.in(-1, 1), y = r.in(-1, 1), z = r.once_in(2) ? 0 : r.in(-1e-3, 0);
      corner = pose_a.rotation * (size * Vec3(x, y, z));
    }
    const Pose pose_b{Mat3::Identity(), pose_a.rotation * over};
    const PairAnswer answer = NarrowPhase().solve(a, pose_a, Shape(t), pose_b, Request::distance);
    if (answer.collide) continue;
    const double unit = radius + length + gap + size;
    const Vec3 between = answer.point_b - answer.point_a;
    REQUIRE((between - answer.signed_distance * answer.normal).norm() <= 1e-9 * unit);
    for (const Vec3& corner : t.vertices) REQUIRE(answer.normal.dot(pose_b * corner - answer.point_b) >= -1e-11 * unit);
  }
}

TEST_CASE("round: long thin cylinders have their points on both surfaces, as far apart as they say") {
  const auto beyond_cylinder = [](const Cylinder& c, const Vec3& p) {
    return std::hypot(std::max(0.0, std::hypot(p[0], p[1]) - c.radius), std::max(0.0, std::abs(p[2]) - 0.5 * c.length));
  };
  const auto beyond_capsule = [](const Capsule& c, const Vec3& p) {
    return std::hypot(std::hypot(p[0], p[1]), std::max(0.0, std::abs(p[2]) - 0.5 * c.length)) - c.radius;
  };
  reference::Random r(25);
  const NarrowPhase solver;
  double worst_beyond = 0, worst_direction = 0, worst_bracket = 0;
  for (int i = 0; i < 12000; ++i) {
    const double length = r.once_in(2) ? 1.0 : r.power_of_two(-13, 0);
    const Cylinder cylinder{r.power_of_two(-23, -7), 1};
    const Capsule capsule{r.power_of_two(-20, -4), length};
    const Pose pose_a{r.rotation(), Vec3::Zero()};
    Pose pose_b{r.rotation(), Vec3::Zero()};
    pose_b.translation = r.in(-0.5, 0.5) * pose_a.rotation.col(2);
    pose_b.translation += r.in(-0.5, 0.5) * length * pose_b.rotation.col(2);
    if (r.once_in(2)) pose_b.translation += r.vec_of_length(0, 2 * capsule.radius);
    const Shape a(cylinder), b(capsule);
    const PairAnswer answer = solver.solve(a, pose_a, b, pose_b, Request::distance);
    REQUIRE(answer.status == Status::ok);
    const Vec3 in_a = pose_a.rotation.transpose() * answer.point_a;
    const Vec3 in_b = pose_b.rotation.transpose() * (answer.point_b - pose_b.translation);
    worst_beyond = std::max({worst_beyond, beyond_cylinder(cylinder, in_a), beyond_capsule(capsule, in_b)});
    worst_direction =
        std::max(worst_direction, (answer.point_b - answer.point_a - answer.signed_distance * answer.normal).norm());
    // Between a capsule inside and one outside, which have a closed form.
    const double inner =
        solver.solve(Shape(Capsule{cylinder.radius, 1 - 2 * cylinder.radius}), pose_a, b, pose_b, Request::distance)
            .signed_distance;
    const double outer =
        solver.solve(Shape(Capsule{cylinder.radius, 1}), pose_a, b, pose_b, Request::distance).signed_distance;
    worst_bracket = std::max({worst_bracket, answer.signed_distance - inner, outer - answer.signed_distance});
  }
  CHECK(worst_beyond <= 1e-14);
  CHECK(worst_direction <= 5e-12);
  CHECK(worst_bracket <= 1e-12);
}

TEST_CASE("round: a flat cone's rim is left straight out where that is the shortest way") {
  const Shape disc(Cone{0.3242694809525214, 1.1879330506922726e-05}),
      small(Cone{0.0779035408596397, 0.0779035408596397});
  const Pose pose_a{
      (Mat3() << 0.9405598074420284, -0.33959262455097255, -0.004908968852691555, 0.33962425619573305,
       0.9403821023150281, 0.018353916450262485, -0.0016165482082408308, -0.018930161017549352, 0.9998195015980335)
          .finished(),
      Vec3::Zero()};
  const Pose pose_b{
      (Mat3() << -0.3395926245059343, 0.004908968916763659, -0.9405598074579552, 0.9403821023308122,
       -0.018353916452401167, -0.3396242561519128, -0.01893016104139856, -0.9998195015976796, 0.001616548147810741)
          .finished(),
      {-0.20438783163118257, -0.28017829965907054, -0.013972709729368066}};
  check_against_truth({disc, pose_a, small, pose_b});
}

TEST_CASE("round: an edge across a flat cone is as far from its side as a formula tells") {
  reference::Random r(27);
  const NarrowPhase n;
  const Shape box(Box{{4, 0.5, 0.5}}), capsule(Capsule{0.1, 4}), cylinder(Cylinder{0.1, 4});
  for (int i = 0; i < 600; ++i) {
    const double height = std::pow(10.0, -r.in(0.5, 9)), slant = std::hypot(1, height), beside = r.in(0.1, 0.9);
    // Above the side at `beside` from the axis: an edge of the box, or a line on a round one.
    const double gap = std::pow(10.0, -r.in(1, 12)), at = (height / 2) - height * beside + gap * slant;
    const double about = r.in(0, 6);
    const Mat3 turn = Eigen::AngleAxisd(about, Vec3::UnitZ()).toRotationMatrix();
    const Mat3 on_edge = Eigen::AngleAxisd(r.in(0.2, 1.3), Vec3::UnitX()).toRotationMatrix();
    const Mat3 lying = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()).toRotationMatrix();
    const Vec3 edge(0, beside, at);
    for (const Shape* other : {&box, &capsule, &cylinder}) {
      const bool is_box = other == &box;
      const Vec3 above(0, 0.1 * height / slant, 0.1 / slant);
      const Vec3 middle = edge + (is_box ? Vec3(on_edge * Vec3(0, 0.25, 0.25)) : above);
      const Pose pose{turn * (is_box ? on_edge : lying), turn * middle};
      CAPTURE(name(other->kind()), i, height, gap);
      const PairAnswer answer = n.solve(Shape(Cone{1, height}), Pose{}, *other, pose, Request::distance);
      REQUIRE(answer.signed_distance == Approx(gap).margin(4e-15).epsilon(0));
    }
  }
}

TEST_CASE("round: the least depth over two rims is found, however narrow it is") {
  const auto about = [](const Vec3& axis, double angle) {
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  };
  const auto check = [](const PosedPair& p) {
    check_against_truth(p);
    CHECK(NarrowPhase().solve(p.a, p.pose_a, p.b, p.pose_b, Request::distance).status == Status::ok);
  };
  const Mat3 disc_turn =
      turned({0.15921221543041653, -0.9118770384184316, -0.3783275528731268, 0.59815060479918158, 0.39396908784219309,
              -0.69785687057100998, 0.78540901728724222, -0.11518951614630751, 0.60816449331892752});
  check({Shape(Cylinder{0.71071330966969815, 0.25538404330875558}),
         {},
         Shape(Cylinder{0.62102732352728807, 0.082726435526131042}),
         {disc_turn, {-0.6787933103192767, 0.46346165132685541, 0.094699101046740231}}});
  const Mat3 cone_turn = turned({0.85683151068151953, -0.089806464619132748, -0.50771503938315399, -0.45149027754672244,
                                 -0.60622223089408322, -0.65471454547045427, -0.24899054516990918, 0.79020845710635912,
                                 -0.55997705554208044});
  check({Shape(Cylinder{0.40595811052465325, 0.39353756164705267}),
         {},
         Shape(Cone{0.66252409876015395, 0.39213322748892832}),
         {cone_turn, {0.26728087440318188, -0.67810400255619574, 0.21741902189744314}}});
  // One circle passes near the other's axis.
  const Mat3 near_axis =
      turned({-0.43637584406880436, -0.85607540495762735, 0.2769675499762983, 0.69383585931171488, -0.12418007709104439,
              0.70934554963489882, -0.57285942695081227, 0.50171128099764406, 0.64816500019153311});
  check({Shape(Cylinder{0.5736858971440868, 0.82453200319712372}),
         {},
         Shape(Cylinder{0.93371753371584765, 1.0636186712127063}),
         {near_axis, {0.36230153481359695, 0.064529020546017807, 0.16708439773118158}}});
  // Circles that are almost concentric.
  check({Shape(Cylinder{0.33535796933232631, 0.52618904982555981}),
         {},
         Shape(Cylinder{0.32725834400581832, 0.045296956530123736}),
         {about({0.2, 1, 1.2}, 2e-5), {-0.005929668046405219, 0.0061149372448676661, -0.0085035271750127876}}});
  check({Shape(Cone{0.76685573056443412, 0.51869214093309091}),
         {},
         Shape(Cone{0.75767127304250725, 0.33913910402645764}),
         {about({-1.6, 0.9, 0.9}, 2e-10), {-0.011951576350643849, 0.015388486649677397, -0.21263408382639915}}});
}

TEST_CASE("round: a disc's rim under a face's edge has minima at the face and between it and the next one") {
  // Along the arc of directions from one face to the other h rises from the first minimum and falls to the second.
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    CAPTURE(seed);
    reference::Random r(62000 + seed);
    const double radius = std::pow(10, r.in(-2, 2)), length = std::pow(10, r.in(-2, 2));
    const Vec3 half{std::pow(10, r.in(-0.5, 0.5)), std::pow(10, r.in(-0.5, 0.5)), std::pow(10, r.in(-0.5, 0.5))};
    const Shape box(Box{2 * half}),
        round = r.once_in(3) ? Shape(Cone{radius, length}) : Shape(Cylinder{radius, length});
    const double tilt = std::pow(10, -r.in(0, 4)), angle = r.in(-3, 3);
    const Mat3 turn = Eigen::AngleAxisd(tilt, Vec3(std::cos(angle), std::sin(angle), 0)).toRotationMatrix();
    const Vec3 down = -turn.row(2).transpose();
    const Vec3 lowest = turn * (radius * Vec3(down[0], down[1], 0).normalized() - Vec3(0, 0, length / 2));
    const double depth = half.minCoeff() * std::pow(10, -r.in(0, 3)),
                 inside = 0.1 * half[0] * std::pow(10, -r.in(0, 6));
    const Pose pose{turn, Vec3(half[0] - inside, r.in(-1, 1) * half[1], half[2] - depth) - lowest};
    const PairAnswer answer = NarrowPhase().solve(box, {}, round, pose, Request::distance);
    if (!answer.collide || answer.status != Status::ok) continue;
    double least = infinity;
    for (int step = 0; step <= 400; ++step) {
      const double at = 0.5 * std::numbers::pi * std::pow(step / 400.0, 4);
      const Vec3 n{std::sin(at), 0, std::cos(at)};
      least = std::min(least, -reference::separation(box, {}, round, pose, n));
    }
    REQUIRE(-answer.signed_distance <= least + 1e-12 * (radius + length + half.norm()));
  }
}

TEST_CASE("round: a disc's axis beside an arc between two faces is not the least depth on it") {
  const Vec3 half{0.60324162835247308, 1.2383237224006867, 1.9143790136952428};
  const Pose pose_a{
      turned({-0.1986542849452948, -0.82886688273355791, 0.52298773004768306, 0.17523175192572338, 0.49498566359049834,
              0.85104819249964669, -0.96427709098055181, 0.26070842630691565, 0.046912772915871703}),
      Vec3::Zero()};
  const Pose pose_b{
      turned({-0.19881311806719965, -0.82886722952779446, 0.52292682078787711, 0.17497326256667828, 0.4949850992080897,
              0.8511017030582948, -0.96429129492657462, 0.26070839529419898, 0.046620072414719396}),
      {0.33717087220439868, 1.9548292495944635, 2.060764917550459}};
  const Shape cone(Cone{2.3148677496494043, 0.28221678069170275});
  std::vector<Vec3> corners;
  for (const double x : {-1, 1})
    for (const double y : {-1, 1})
      for (const double z : {-1, 1}) corners.push_back(half.cwiseProduct(Vec3(x, y, z)));
  for (const Shape& a : {Shape(Box{2 * half}), Shape(Convex{corners})}) {
    const PairAnswer answer = NarrowPhase().solve(a, pose_a, cone, pose_b, Request::distance);
    CHECK(answer.status == Status::ok);
    CHECK(std::abs(answer.signed_distance + 0.11952414790772647) < 1e-12);
  }
}

TEST_CASE("round: a flat ellipsoid's edge under a box's has a minimum beside that at the box's face") {
  const Pose pose_a{
      turned({-0.64763302195017025, 0.7324204761739328, 0.21007549824013044, 0.19383706490324654, -0.10826703393826143,
              0.97504125124627694, 0.73688442862458703, 0.67218933005765602, -0.071852929009575073}),
      Vec3::Zero()};
  const Pose pose_b{
      turned({-0.65053064346835898, 0.73061609822117068, 0.20738852168988187, 0.18029024939725388, -0.11670277168927998,
              0.97666569974188977, 0.73777049810962081, 0.67274109440416374, -0.055804229400374737}),
      {0.96962944691600894, -0.06125370917247161, 0.011836613447525735}};
  const Shape box(Box{2 * Vec3(0.35580034312887471, 2.3448971078375407, 0.40157007830878177)});
  const Shape plate(Ellipsoid{{0.98775929750006342, 0.045002473163083312, 0.00036651889009903547}});
  const PairAnswer answer = NarrowPhase().solve(box, pose_a, plate, pose_b, Request::distance);
  CHECK(answer.status == Status::ok);
  CHECK(std::abs(answer.signed_distance + 0.2721701805677067) < 1e-12);  // at the face: 0.2721716649
}

TEST_CASE("a flat ellipsoid beside a hull's edge: the edge's point, where Newton's method ends with one of its ends") {
  const Shape hull(Convex{{{-0.14388625511614017, 0.2588139024081908, 0.76024212847009287},
                           {0.51395122123232606, -0.78706165569682907, 0.2292538850883199},
                           {-0.24291222875077145, 0.68705183588682495, -0.15957779494599644},
                           {0.18503248305809294, -0.26412387664431913, 0.49474800677920638}}});
  const Shape ellipsoid(Ellipsoid{{0.063742762024440541, 1.0999901574089877e-05, 0.86543933177120547}});
  Pose a, b;
  a.rotation << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  b.rotation << 0.6529805491187779, -0.43973149149841706, 0.61664626639355946, 0.70718490652190968, 0.64545451301737033,
      -0.28857924321251355, -0.27111973454571153, 0.62451956495380245, 0.73244071605132399;
  b.translation = {-0.73448078194318489, 0.086717326051132776, 0.56138181489568673};
  const PairAnswer r = NarrowPhase().solve(hull, a, ellipsoid, b, Request::distance);
  CHECK(r.status == Status::ok);
  CHECK(std::abs(r.signed_distance - 0.3267175953643311) < 1e-12);
  CHECK((r.point_b - r.point_a - r.signed_distance * r.normal).norm() < 1e-9);
}
