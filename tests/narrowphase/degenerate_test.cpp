// Shapes that just touch, in all special configurations: barely separated, exactly touching, barely overlapping,
// aligned and slightly tilted, along the world's axes and in general position. And degenerate shapes.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "catch.h"
#include "judge.h"
#include "random.h"

using namespace tandem;
using namespace tandem::test;
using reference::PosedPair;
using reference::Random;

namespace {

struct Touch {
  std::string name;
  Shape a, b;
  Mat3 turn;   ///< rotation of B
  Vec3 reach;  ///< B's translation where they touch
};

Mat3 about(const Vec3& axis, double angle) { return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(); }

/// Exact quarter and half turns.
Mat3 z_to_x() { return (Mat3() << 0, 0, 1, 0, 1, 0, -1, 0, 0).finished(); }
Mat3 z_to_y() { return (Mat3() << 1, 0, 0, 0, 0, 1, 0, -1, 0).finished(); }
Mat3 upside_down() { return Vec3(1, -1, -1).asDiagonal(); }

std::vector<Touch> touches() {
  const Mat3 straight = Mat3::Identity();
  const Shape sphere(Sphere{0.5}), point(Sphere{0}), box(Box{{1, 2, 3}}), cube(Box{{1, 1, 1}}),
      capsule(Capsule{0.25, 1.5}), ball(Capsule{0.25, 0}), cylinder(Cylinder{0.5, 1}), cone(Cone{0.5, 1}),
      ellipsoid(Ellipsoid{{0.5, 0.75, 1}}), ground(HalfSpace{{0, 0, 1}, 0}),
      tetrahedron(Convex{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}),
      triangle(Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}}),
      square(Convex{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}}), segment(Convex{{{-1, 0, 0}, {1, 0, 0}}});
  return {
      {"spheres", sphere, sphere, straight, {0, 0, 1}},
      {"points", point, point, straight, {0, 0, 0}},
      {"sphere on a face", box, sphere, straight, {0, 0, 2}},
      {"sphere on an edge", cube, sphere, straight, Vec3(0.5, 0.5, 0) + 0.5 * Vec3(1, 1, 0).normalized()},
      {"sphere on a corner", cube, sphere, straight, Vec3(0.5, 0.5, 0.5) + 0.5 * Vec3(1, 1, 1).normalized()},
      {"boxes, face to face", box, cube, straight, {0, 0, 2}},
      {"boxes, half a face", box, cube, straight, {1, 0.5, 1}},
      {"boxes, edge along edge", box, cube, straight, {1, 1.5, 0}},
      {"boxes, corner to corner", box, cube, straight, {1, 1.5, 2}},
      {"boxes, edge across edge",
       cube,
       cube,
       about({0, 1, 0}, 0.78539816339744828) * z_to_x(),
       {0.5, 0.5, 1.2071067811865475}},
      {"boxes, the same", cube, cube, straight, {0, 0, 0}},
      {"capsules, end to end", capsule, capsule, straight, {0, 0, 2}},
      {"capsules, side by side", capsule, capsule, straight, {0.5, 0, 0}},
      {"capsules, crossed", capsule, capsule, z_to_x(), {0, 0.5, 0}},
      {"capsules, axes crossing", capsule, capsule, z_to_x(), {0, 0, 0}},
      {"capsules, one axis", capsule, ball, straight, {0, 0, 0.5}},
      {"capsule on a face", box, capsule, z_to_x(), {0, 0, 1.75}},
      {"capsule on end on a face", box, capsule, straight, {0, 0, 2.5}},
      {"cylinders, end to end", cylinder, cylinder, straight, {0, 0, 1}},
      {"cylinders, side by side", cylinder, cylinder, straight, {1, 0, 0}},
      {"cylinders, crossed", cylinder, cylinder, z_to_x(), {0, 1, 0}},
      {"cylinders, rim to rim", cylinder, cylinder, straight, {1, 0, 1}},
      {"cylinders, the same", cylinder, cylinder, straight, {0, 0, 0}},
      {"cylinder standing on a box", box, cylinder, straight, {0, 0, 2}},
      {"cylinder lying on a box", box, cylinder, z_to_x(), {0, 0, 2}},
      {"cones, apex to apex", cone, cone, upside_down(), {0, 0, 1}},
      {"cones, apex to base", cone, cone, straight, {0, 0, 1}},
      {"cones, base to base", cone, cone, upside_down(), {0, 0, -1}},
      {"cones, the same", cone, cone, straight, {0, 0, 0}},
      {"cone, apex to a face", box, cone, upside_down(), {0, 0, 2}},
      {"cone and cylinder, end to end", cylinder, cone, straight, {0, 0, 1}},
      {"ellipsoids, tip to tip", ellipsoid, ellipsoid, straight, {0, 0, 2}},
      {"ellipsoids, flank to flank", ellipsoid, ellipsoid, z_to_x(), {1.5, 0, 0}},
      {"ellipsoids, the same", ellipsoid, ellipsoid, straight, {0, 0, 0}},
      {"ellipsoid on a box", box, ellipsoid, z_to_y(), {0, 0, 2.25}},
      {"box on the ground", ground, box, straight, {0, 0, 1.5}},
      {"cylinder on the ground", ground, cylinder, z_to_x(), {0, 0, 0.5}},
      {"cone on the ground", ground, cone, straight, {0, 0, 0.5}},
      {"triangle on the ground", ground, triangle, straight, {0, 0, 0}},
      {"tetrahedra, corner to face", tetrahedron, tetrahedron, straight, {0.25, 0.25, -1}},
      {"tetrahedra, edge along edge", tetrahedron, tetrahedron, upside_down(), {0, 0, 0}},
      {"tetrahedron on a box", cube, tetrahedron, straight, {-0.25, -0.25, 0.5}},
      {"triangles, face to face", triangle, triangle, straight, {0.25, 0.25, 0}},
      {"triangles, edge to edge in one plane", triangle, triangle, straight, {1, 0, 0}},
      {"triangles, corner to corner", triangle, triangle, upside_down(), {0, 0, 0}},
      {"triangle in a box's face", cube, triangle, straight, {-0.25, -0.25, 0.5}},
      {"squares, face to face", square, square, straight, {0.5, 0.5, 0}},
      {"segments, crossed", segment, segment, z_to_x() * z_to_y(), {0, 0, 0}},
      {"segments, end to end", segment, segment, straight, {2, 0, 0}},
      {"segment along a box's edge", cube, segment, straight, {0, 0.5, 0.5}},
      {"segment on a cylinder's axis", cylinder, segment, z_to_x(), {0, 0, 1.5}},
  };
}

/// True if no verdict is wrong and all numbers are finite, and only last digits of depths and points differ, for
/// polytopes.
bool only_digits(const std::string& wrong, const PosedPair& p) {
  for (const ShapeKind k : {p.a.kind(), p.b.kind()})
    if (k == ShapeKind::cylinder || k == ShapeKind::cone || k == ShapeKind::ellipsoid) return wrong.empty();
  for (const char* grave : {"collides across", "does not collide", "not finite", "another verdict", "disagrees"})
    if (wrong.find(grave) != std::string::npos) return false;
  return true;
}

}  // namespace

TEST_CASE("degenerate: touching is touching, and a hair either way is not lost") {
  const NarrowPhase solver;
  Random r(7);
  int judged = 0, short_of_digits = 0;
  for (const Touch& t : touches())
    for (const double tilt : {0.0, 1e-9})
      for (const double hair : {0.0, 0x1p-51, -0x1p-51, 1e-11, -1e-11, 1e-4, -1e-4})
        for (const bool general : {false, true}) {
          if (general && tilt > 0) continue;
          const Vec3 heading = t.reach.norm() > 0 ? Vec3(t.reach.normalized()) : Vec3::UnitZ();
          Pose world;
          const Mat3 turn = r.rotation();
          const Vec3 shift = r.vec(-3, 3);
          if (general) world = {turn, shift};
          const Mat3 tilted = about({1, 2, -1}, tilt) * t.turn;
          const PosedPair p{t.a, world, t.b, {world.rotation * tilted, world * Vec3(t.reach + hair * heading)}};
          const auto truth = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
          const std::string wrong = judge(solver, p, truth);
          if (!wrong.empty()) ++short_of_digits;
          if (!only_digits(wrong, p))
            FAIL_CHECK(t.name << ", hair " << hair << ", tilt " << tilt << '\n' << wrong << record(p));
          ++judged;
        }
  CHECK(judged > 1000);
  // With faces that slant by 1e-9, witness points 1e-9 apart are equally good.
  CHECK(short_of_digits <= 2);
}

TEST_CASE("degenerate: needles, plates, flat hulls, points and shapes of very different size are answered") {
  std::vector<Shape> shapes;
  shapes.emplace_back(Sphere{0});
  shapes.emplace_back(Sphere{1e-9});
  shapes.emplace_back(Box{{1e-6, 1, 1}});
  shapes.emplace_back(Box{{1e-6, 1e-6, 1}});
  shapes.emplace_back(Box{{1e4, 1e4, 1e-2}});
  shapes.emplace_back(Capsule{1e-6, 1});
  shapes.emplace_back(Capsule{0.3, 0});
  shapes.emplace_back(Cylinder{1, 1e-5});
  shapes.emplace_back(Cylinder{1e-5, 1});
  shapes.emplace_back(Cone{1e-4, 1});
  shapes.emplace_back(Cone{1, 1e-4});
  shapes.emplace_back(Ellipsoid{{1e-4, 1, 1}});
  shapes.emplace_back(Ellipsoid{{1e-4, 1e-4, 1}});
  shapes.emplace_back(Convex{{{0.1, 0.2, 0.3}}});
  shapes.emplace_back(Convex{{{-1, 0, 0}, {1, 0, 0}}});
  shapes.emplace_back(Convex{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}});
  shapes.emplace_back(Convex{{{-1, -1, 0}, {1, -1, 1e-9}, {1, 1, 0}, {-1, 1, 0}}});
  shapes.emplace_back(Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)}});
  shapes.emplace_back(Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, 1e-7, 0)}});
  const NarrowPhase solver;
  Random r(11);
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = i; j < shapes.size(); ++j)
      for (const Vec3& t : {Vec3(0, 0, 0), Vec3(0, 0, 1e-9), Vec3(0.5, 0, 0), Vec3(0, 1e3, 0)}) {
        const Mat3 turn = r.rotation();
        const PosedPair p{shapes[i], {}, shapes[j], {t.x() == 0.5 ? turn : Mat3(Mat3::Identity()), t}};
        const auto truth = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
        const std::string wrong = judge(solver, p, truth);
        if (!wrong.empty()) FAIL_CHECK(wrong << record(p));
      }
}

TEST_CASE("degenerate: gaps so small that their squares are lost still have a unit normal") {
  const NarrowPhase solver;
  const Shape point(Sphere{0});
  for (const double gap : {1e-100, 1e-150, 1e-157, 1.5463159719809281e-158, 1e-160, 1e-163, 1e-300, 3e-310}) {
    const Shape segment(Convex{{{0, 1, -1}, {gap, 0, 0}}});
    const Shape triangle(Triangle{{Vec3(gap, 1, -1), Vec3(gap, 0, 0), Vec3(gap, -1, -1)}});
    for (const Shape* other : {&segment, &triangle})
      for (const bool swapped : {false, true}) {
        CAPTURE(gap, name(other->kind()), swapped);
        const PairAnswer r =
            solver.solve(swapped ? point : *other, {}, swapped ? *other : point, {}, Request::distance);
        CHECK(std::abs(r.signed_distance) < 1e-15);
        CHECK(std::abs(r.normal.norm() - 1) < 1e-12);
      }
  }
}

TEST_CASE("degenerate: a flat hull with an edge so short that its square is lost, in a cone") {
  const NarrowPhase solver;
  const Shape cone(Cone{0.1, 3});
  for (const double side : {0.0, 1e-100, 1e-160, 1e-200, 1e-283, 3e-310}) {
    const Shape hull(Convex{{{3, side, 0}, {3, 0, 0}, {0.1, -1, 0}, {0, 0, 0}}});
    CAPTURE(side);
    const PairAnswer r = solver.solve(cone, {}, hull, {}, Request::distance);
    CHECK(r.status == Status::ok);
    CHECK(r.signed_distance == Approx(-0.0499722453489577).epsilon(1e-12));
    CHECK(std::abs(r.normal.norm() - 1) < 1e-12);
  }
}

namespace {

/// A shape of the kind about the origin, with simple numbers.
Shape round_shape(ShapeKind kind) {
  switch (kind) {
    case ShapeKind::sphere:
      return Shape(Sphere{0});
    case ShapeKind::box:
      return Shape(Box{{0.5, 1, 3}});
    case ShapeKind::capsule:
      return Shape(Capsule{0.25, 0});
    case ShapeKind::cylinder:
      return Shape(Cylinder{1, 0.5});
    case ShapeKind::cone:
      return Shape(Cone{0.5, 1});
    case ShapeKind::ellipsoid:
      return Shape(Ellipsoid{{0.5, 1, 2}});
    case ShapeKind::halfspace:
      return Shape(HalfSpace{{0, 0, 1}, 0});
    case ShapeKind::plane:
      return Shape(Plane{{0, 0, 1}, 0.125});
    case ShapeKind::convex:
      return Shape(Convex{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 0.5}, {0, 0, -0.5}}});
    case ShapeKind::triangle:
      return Shape(Triangle{{Vec3(1, 0, 0), Vec3(-1, 1, 0), Vec3(-1, -1, 0)}});
    case ShapeKind::voxels:
      return Shape(Voxels{{{{0, 0, 0}, 0}, {{-1, -1, -1}, 0}, {{-2, 0, 0}, 1}}, 0.5});
    default:
      return Shape(Mesh{
          {{1, 0, -1}, {-1, 1, -1}, {-1, -1, -1}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, false});
  }
}

/// A rotation by tiny angles about each axis.
Mat3 hardly_turned(const Vec3& v) {
  return (Mat3() << 1, -v.z(), v.y(), v.z(), 1, -v.x(), -v.y(), v.x(), 1).finished();
}

bool is_unit(const Vec3& n) { return std::abs(n.norm() - 1) < 1e-12; }

}  // namespace

TEST_CASE("degenerate: places and turns so small that their squares are lost change nothing") {
  const NarrowPhase solver;
  Random r(5);
  for (std::size_t i = 0; i < shape_kinds; ++i)
    for (std::size_t j = 0; j < shape_kinds; ++j) {
      const Shape a = round_shape(static_cast<ShapeKind>(i)), b = round_shape(static_cast<ShapeKind>(j));
      if (!a.is_bounded() && !b.is_bounded()) continue;
      for (const double tiny : {1e-100, 1e-145, 1e-153, 1e-156, 1e-158, 1e-159, 1e-160, 1e-161, 1e-162, 1e-170, 3e-310})
        for (const bool along_axis : {true, false})
          for (const bool turned : {true, false}) {
            const Vec3 heading = along_axis ? Vec3(Vec3::Unit(r.below(3))) : r.direction();
            const Mat3 turn = turned ? hardly_turned(Vec3{tiny * r.sign(), tiny * r.unit(), tiny * r.sign()})
                                     : Mat3(r.once_in(2) ? z_to_x() : z_to_y());
            CAPTURE(name(a.kind()), name(b.kind()), tiny, along_axis, turned, heading.transpose());
            const PairAnswer none =
                solver.solve(a, {}, b, {turned ? Mat3(Mat3::Identity()) : turn, Vec3::Zero()}, Request::distance);
            std::vector<Contact> contacts;
            for (const Request request : {Request::distance, Request::contacts}) {
              const PairAnswer d = solver.solve(a, {}, b, {turn, tiny * heading}, request, &contacts);
              if (request == Request::contacts && !d.collide) continue;
              CHECK(is_unit(d.normal));
              if (request == Request::contacts && (i == 9 || j == 9)) continue;  // a patch has its own depth
              const double bound = 1e-12 + d.error_bound + none.error_bound;
              CHECK(std::abs(d.signed_distance - none.signed_distance) <= bound);
              CHECK((d.point_b - d.point_a - d.signed_distance * d.normal).norm() < 1e-9);
            }
            for (const Contact& c : contacts) {
              CHECK(is_unit(c.normal));
              CHECK(c.point.allFinite());
            }
          }
    }
}

TEST_CASE("degenerate: triangles with corners so near each other that the square of what parts them is lost") {
  const NarrowPhase solver;
  Random r(6);
  const auto corner = [&] {
    Vec3 p;
    for (int k = 0; k < 3; ++k) {
      const bool on_grid = r.once_in(2);
      const double sign = on_grid ? 1 : r.sign();
      p[k] = on_grid ? 0.5 * (r.below(5) - 2) : sign * std::pow(10.0, -r.in(100, 200));
    }
    return p;
  };
  const auto rounded = [](std::array<Vec3, 3> p) {
    for (Vec3& v : p)
      for (int k = 0; k < 3; ++k)
        if (std::abs(v[k]) < 1e-90) v[k] = 0;
    return p;
  };
  const auto as = [](ShapeKind kind, const std::array<Vec3, 3>& p) {
    if (kind == ShapeKind::triangle) return Shape(Triangle{p});
    if (kind == ShapeKind::convex) return Shape(Convex{{p.begin(), p.end()}});
    return Shape(Mesh{{p.begin(), p.end()}, {{0, 1, 2}}, false});
  };
  for (int k = 0; k < 400; ++k) {
    const std::array<Vec3, 3> p{corner(), corner(), corner()};
    const Shape other = round_shape(static_cast<ShapeKind>(k % static_cast<int>(shape_kinds)));
    for (const ShapeKind kind : {ShapeKind::triangle, ShapeKind::convex, ShapeKind::mesh}) {
      const Pose pose{k % 3 == 0 ? z_to_x() : Mat3(Mat3::Identity()), k % 2 == 0 ? Vec3(0, 0, 0) : Vec3(0.5, 0, -0.5)};
      CAPTURE(k, name(kind), name(other.kind()), p[0].transpose(), p[1].transpose(), p[2].transpose());
      std::optional<Shape> shape, plain;
      try {
        shape = as(kind, p), plain = as(kind, rounded(p));
      } catch (const std::invalid_argument&) {
        continue;  // smaller than a shape may be
      }
      const PairAnswer d = solver.solve(*shape, {}, other, pose, Request::distance);
      const PairAnswer e = solver.solve(*plain, {}, other, pose, Request::distance);
      CHECK(is_unit(d.normal));
      CHECK(std::abs(d.signed_distance - e.signed_distance) <= 1e-12 + d.error_bound + e.error_bound);
      CHECK((d.point_b - d.point_a - d.signed_distance * d.normal).norm() < 1e-9);
    }
  }
}

TEST_CASE("degenerate: a mesh's triangle without area is as far from round shapes as the triangle by itself") {
  const NarrowPhase solver;
  Random r(19);
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = r.vec(-1, 1), q = r.vec(-1, 1);
    std::array<Vec3, 3> corners{p, q, i % 3 == 0 ? p : i % 3 == 1 ? q : Vec3(0.5 * (p + q))};
    std::rotate(corners.begin(), corners.begin() + i / 3 % 3, corners.end());
    const Shape triangle(Triangle{corners}), mesh(Mesh{{corners.begin(), corners.end()}, {{0, 1, 2}}, false});
    const double size = std::pow(10.0, -r.in(0, 4)), thin = size * std::pow(10.0, -r.in(0, 8));
    for (const Shape& round : {Shape(Cylinder{thin, size}), Shape(Cylinder{size, thin}), Shape(Cone{thin, size}),
                               Shape(Ellipsoid{{thin, size, thin}})}) {
      const Pose pose{r.rotation(), 0.6 * p + 0.4 * q + size * r.vec_of_length(0, 0.7)};
      CAPTURE(i, size, thin, name(round.kind()));
      const PairAnswer one = solver.solve(triangle, {}, round, pose, Request::distance);
      const PairAnswer other = solver.solve(mesh, {}, round, pose, Request::distance);
      CHECK(std::abs(one.signed_distance - other.signed_distance) <= 1e-12 + one.error_bound + other.error_bound);
      if (other.signed_distance > 0)
        CHECK((other.point_b - other.point_a - other.signed_distance * other.normal).norm() < 1e-9);
    }
  }
}

TEST_CASE("degenerate: a warm start of any length leads to the same answer") {
  const NarrowPhase solver;
  for (const ShapeKind kind : {ShapeKind::convex, ShapeKind::cylinder}) {
    const Shape a = round_shape(kind), b = round_shape(ShapeKind::convex);
    const Pose pose{z_to_x(), {2, 0.5, 0.25}};
    const PairAnswer cold = solver.solve(a, {}, b, pose, Request::distance);
    for (const double length : {0.0, 3e-310, 1e-160, 1e-100, 1.0, 1e100, 1e160, 1e300}) {
      CAPTURE(name(kind), length);
      const Vec3 direction = length * (cold.normal + Vec3(0.01, -0.02, 0.03));
      WarmStart warm{direction};
      const PairAnswer d = solver.solve(a, {}, b, pose, Request::distance, nullptr, &warm);
      CHECK(d.signed_distance == Approx(cold.signed_distance).epsilon(1e-12));
      CHECK(is_unit(d.normal));
      WarmStart again{direction};
      CHECK_FALSE(solver.solve(a, {}, b, pose, Request::collide, nullptr, &again).collide);
    }
  }
}

TEST_CASE("degenerate: two points in one place touch, and no bound is left open") {
  const Shape point(Sphere{0}), mesh(Mesh{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}}, false});
  std::vector<Contact> contacts;
  const PairAnswer r = NarrowPhase().solve(point, {}, mesh, {}, Request::contacts, &contacts);
  CHECK(r.collide);
  CHECK(r.status == Status::ok);
  CHECK(r.error_bound == 0);
  REQUIRE(contacts.size() == 1);
  CHECK(contacts[0].depth == 0);
}
