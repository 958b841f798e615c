// A two-sided plane answers like two half-spaces, one on each side.
#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.h"
#include "mesh_samples.h"
#include "random_pairs.h"
#include "tandem/narrowphase/clearance.h"
#include "tandem/narrowphase/shape_makers.h"

using namespace tandem;
using namespace tandem::test;

namespace {

constexpr ShapeKind bodies[] = {ShapeKind::sphere,   ShapeKind::box,      ShapeKind::capsule,
                                ShapeKind::cylinder, ShapeKind::cone,     ShapeKind::ellipsoid,
                                ShapeKind::convex,   ShapeKind::triangle, ShapeKind::mesh};

Shape side_of(const Shape& plane, double sense) { return HalfSpace{sense * plane.normal(), sense * plane.offset()}; }

/// The nearest triangle's distance, by brute force; 0 where one intersects the plane.
double nearest_triangle(const Shape& plane, const Pose& pose, const Shape& mesh, const Pose& pose_mesh) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles()) {
    double lo = least, hi = -least;
    for (const std::uint32_t v : t) {
      const double height =
          plane.normal().dot(pose.rotation.transpose() * (pose_mesh * mesh.vertices()[v] - pose.translation)) -
          plane.offset();
      lo = std::min(lo, height), hi = std::max(hi, height);
    }
    least = std::min(least, lo <= 0 && hi >= 0 ? 0 : std::min(std::abs(lo), std::abs(hi)));
  }
  return least;
}

/// Balls about points in two clouds, the second `apart` above the first.
Shape two_clouds(Random& r, double apart, double radius) {
  std::vector<Vec3> points;
  for (int i = 0; i < 200; ++i) {
    const Vec3 p = r.vec(-0.5, 0.5);
    points.push_back(i % 2 == 0 ? p : Vec3(p + Vec3(0, 0, 1 + apart)));
  }
  return point_cloud(points, radius);
}

}  // namespace

TEST_CASE("plane: every request answers as the half-space that less of a body sticks out of") {
  Random r(71);
  const NarrowPhase solver({.margin = 0.1});
  int cut = 0, apart = 0;
  for (const ShapeKind kind : bodies)
    for (int i = 0; i < 120; ++i) {
      const Shape plane = random_shape(ShapeKind::plane, r);
      Shape body = random_shape(kind, r);
      if (i % 4 == 3) body = body.rounded(0.1);
      const Pose pp = random_pose(r, 0.5), pb = random_pose(r, 1);
      CAPTURE(name(kind), i);
      const auto distance = [&](const Shape& s) { return solver.solve(s, pp, body, pb, Request::distance); };
      const PairAnswer above = distance(side_of(plane, 1)), below = distance(side_of(plane, -1));
      const bool over = above.signed_distance >= below.signed_distance;
      const PairAnswer &expected = over ? above : below, &answer = distance(plane);
      CHECK(answer.signed_distance == Approx(expected.signed_distance).margin(1e-14));
      CHECK((answer.normal - expected.normal).norm() < 1e-14);
      CHECK((answer.point_a - expected.point_a).norm() < 1e-13);
      CHECK((answer.point_b - expected.point_b).norm() < 1e-13);
      CHECK(answer.collide == (above.collide && below.collide));
      CHECK(solver.solve(plane, pp, body, pb, Request::collide).collide == answer.collide);
      ++(answer.collide ? cut : apart);
      std::vector<Contact> contacts, of_side, exchanged;
      const PairAnswer near = solver.solve(plane, pp, body, pb, Request::contacts, &contacts);
      solver.solve(side_of(plane, over ? 1 : -1), pp, body, pb, Request::contacts, &of_side);
      REQUIRE(contacts.size() == of_side.size());
      CHECK(contacts.empty() == (answer.signed_distance > 0.1));
      for (std::size_t k = 0; k < contacts.size(); ++k) {
        CHECK(contacts[k].depth == Approx(of_side[k].depth).margin(1e-14));
        CHECK((contacts[k].point - of_side[k].point).norm() < 1e-13);
      }
      const PairAnswer back = solver.solve(body, pb, plane, pp, Request::contacts, &exchanged);
      CHECK(exchanged.size() == contacts.size());
      if (!contacts.empty()) CHECK(back.normal == -near.normal);
    }
  CHECK(cut > 200);
  CHECK(apart > 200);
}

TEST_CASE("plane: moved by its depth along the normal, a body touches it no more") {
  Random r(72);
  const NarrowPhase solver;
  int touching = 0;
  for (int i = 0; i < 180; ++i) {
    const Shape plane = random_shape(ShapeKind::plane, r), body = random_shape(bodies[i % 9], r);
    const Pose at = random_pose(r, 0.5);
    Pose pose = random_pose(r, 1);
    const PairAnswer d = solver.solve(plane, at, body, pose, Request::distance);
    if (!d.collide) continue;
    pose.translation += (1e-9 - d.signed_distance) * d.normal;
    CHECK_FALSE(solver.solve(plane, at, body, pose, Request::collide).collide);
    ++touching;
  }
  CHECK(touching > 50);
}

TEST_CASE("plane: a mesh in pieces has the distance of the nearest, on either side") {
  Random r(73);
  const NarrowPhase solver;
  int between = 0, cut = 0;
  for (int i = 0; i < 300; ++i) {
    const double radius = i % 2 == 0 ? 0 : 0.05;
    const Shape cloud = two_clouds(r, r.in(-0.2, 0.6), radius);
    const Shape plane = Plane{Vec3{r.in(-0.1, 0.1), r.in(-0.1, 0.1), 1}, r.in(-1, 1)};
    const Pose turn = random_pose(r, 3), pose{turn.rotation, turn * Vec3(0, 0, r.in(0, 1))};
    const double d = nearest_triangle(plane, pose, cloud, turn) - radius;
    if (std::abs(d) < 1e-9) continue;
    CAPTURE(i, d);
    const PairAnswer answer = solver.solve(plane, pose, cloud, turn, Request::distance);
    CHECK(answer.collide == (d < 0));
    CHECK(solver.solve(plane, pose, cloud, turn, Request::collide).collide == (d < 0));
    if (d < 0) {
      ++cut;
      CHECK(answer.signed_distance < 0);
      Pose out = turn;
      out.translation += (1e-9 - answer.signed_distance) * answer.normal;
      CHECK_FALSE(solver.solve(plane, pose, cloud, out, Request::collide).collide);
    } else {
      CHECK(answer.signed_distance == Approx(d).margin(1e-12));
      const bool is_hull_cut = solver.solve(side_of(plane, 1), pose, cloud, turn, Request::collide).collide &&
                               solver.solve(side_of(plane, -1), pose, cloud, turn, Request::collide).collide;
      between += is_hull_cut;
    }
  }
  CHECK(between > 20);
  CHECK(cut > 50);
}

TEST_CASE("plane: a mesh in pieces comes out through the nearest place without triangles") {
  // Two boxes as one mesh, from -11 to -9 and from -0.001 to 1.999.
  Mesh crates = box_mesh({2, 2, 2});
  const std::size_t corners = crates.vertices.size(), faces = crates.triangles.size();
  for (std::size_t v = 0; v < corners; ++v) {
    crates.vertices.push_back(crates.vertices[v] + Vec3(0, 0, 0.999));
    crates.vertices[v].z() -= 10;
  }
  for (std::size_t t = 0; t < faces; ++t) {
    auto above = crates.triangles[t];
    for (std::uint32_t& v : above) v += static_cast<std::uint32_t>(corners);
    crates.triangles.push_back(above);
  }
  crates.solid = true;
  const Shape mesh(crates), plane = Plane{{0, 0, 1}, 0};
  for (const double margin : {0.0, 0.01})
    for (const double lift : {0.0, 0.003}) {  // overlapping by 0.001, or 0.002 above
      CAPTURE(margin, lift);
      const double expected = lift - 0.001;
      const NarrowPhase solver({.margin = margin});
      const PairAnswer answer = solver.solve(plane, Pose{}, mesh, Pose::at(0, 0, lift), Request::distance);
      CHECK(answer.signed_distance == Approx(expected).margin(1e-12));
      CHECK(answer.normal.z() == Approx(1));
      std::vector<Contact> contacts;
      solver.solve(plane, Pose{}, mesh, Pose::at(0, 0, lift), Request::contacts, &contacts);
      CHECK(contacts.size() == (expected <= margin ? 4u : 0u));
      for (const Contact& c : contacts) CHECK(c.depth == Approx(-expected).margin(1e-12));
    }
}

TEST_CASE("plane: what moves straight through a gap of a mesh is met by the piece that comes") {
  Random r(74);
  const NarrowPhase solver;
  int met = 0;
  for (int i = 0; i < 60; ++i) {
    const double radius = i % 3 == 0 ? 0.02 : 0;
    const Shape cloud = two_clouds(r, 0.5, radius), plane = Plane{{0, 0, 1}, 0.6 + r.in(0, 0.3)};
    for (const double sense : {1.0, -1.0}) {
      const Vec3 v = sense * Vec3{r.in(-1, 1), r.in(-1, 1), 1};
      const auto t = solver.time_of_impact(plane, {}, Vec3::Zero(), cloud, {}, v, 1);
      REQUIRE(t);
      const auto at = [&](double time) { return Pose{Mat3::Identity(), time * v}; };
      CHECK(std::abs(nearest_triangle(plane, {}, cloud, at(*t)) - radius) < 1e-9);
      for (int k = 0; k < 20; ++k)
        if (*t > 0) CHECK(nearest_triangle(plane, {}, cloud, at(0.05 * k * *t)) > radius);
      const auto turned = solver.time_of_impact(plane, Motion{}, cloud, Motion{{}, at(1)});
      REQUIRE(turned);
      CHECK(std::abs(turned->t - *t) < 1e-6);
      met += *t > 0;
    }
  }
  CHECK(met > 100);
}

TEST_CASE("plane: with planes and half-spaces there is a verdict alone, rounding counted") {
  const NarrowPhase n;
  const Shape low(Plane{{0, 0, 1}, 1}), high(Plane{{0, 0, -1}, -2}), aslant(Plane{{0, 1, 1}, 0}), ground(HalfSpace{});
  const auto meet = [&](const Shape& a, const Shape& b, double up = 0) {
    const bool answer = n.solve(a, Pose::at(0, 0, up), b, {}, Request::collide).collide;
    CHECK(answer == n.solve(b, {}, a, Pose::at(0, 0, up), Request::collide).collide);
    return answer;
  };
  CHECK_FALSE(meet(low, high));
  CHECK(meet(low, high, 1));
  CHECK_FALSE(meet(low, high, 2));
  CHECK(meet(low, aslant));
  CHECK_FALSE(meet(low, ground));
  CHECK(meet(low, ground, -1));
  CHECK(meet(low, ground, -5));
  CHECK(meet(low.rounded(0.5), high.rounded(0.5)));
  CHECK_FALSE(meet(low.rounded(0.25), high.rounded(0.5)));
  CHECK(meet(low.rounded(1), ground));
  CHECK_THROWS_AS(n.solve(low, {}, ground, {}, Request::distance), std::invalid_argument);
}

TEST_CASE("plane: what moves along a direction leaves it on the far side") {
  const Shape plane = Plane{}, ball = Sphere{0.5};
  const auto reach = [&](double height, const Vec3& d) {
    return separation_along(plane, {}, ball, Pose::at(0, 0, height), d);
  };
  CHECK(reach(0.2, Vec3::UnitZ()) == Approx(0.3));
  CHECK(reach(0.2, -Vec3::UnitZ()) == Approx(0.7));
  CHECK(reach(2, -Vec3::UnitZ()) == Approx(2.5));
  CHECK(reach(2, Vec3::UnitZ()) == 0);
  CHECK(reach(2, Vec3::UnitX()) == 0);
  CHECK(reach(-2, Vec3::UnitX()) == 0);
  CHECK(reach(-2, Vec3(1, 0, 1e-17)) == 0);
  CHECK(reach(-2, Vec3(1, 0, -1e-17)) == 0);
  CHECK(std::isinf(reach(0.2, Vec3::UnitX())));
  CHECK(separation_along(ball, Pose::at(0, 0, 0.2), plane, {}, Vec3::UnitZ()) == Approx(0.7));
}

TEST_CASE("plane: its box is flat where its normal is an axis, and rounding makes it a slab") {
  const Bounds flat = Shape(Plane{{0, 0, 2}, 3}).bounds(Pose::at(0, 0, 1));
  CHECK(flat.lo.z() == 2.5);
  CHECK(flat.hi.z() == 2.5);
  CHECK(flat.lo.x() == -1e300);
  CHECK(Shape(Plane{{0, 1, 1}, 3}).bounds({}).hi.z() == 1e300);
  const Shape slab = Shape(Plane{}).rounded(0.5);
  CHECK(slab.rounding() == 0.5);
  CHECK(slab.size() == 0);
  CHECK(slab.bounds({}).hi.z() == 0.5);
  const NarrowPhase n;
  CHECK(n.solve(slab, {}, Sphere{1}, Pose::at(0, 0, -4), Request::distance).signed_distance == Approx(2.5));
  CHECK(n.solve(slab, {}, Sphere{1}, Pose::at(0, 0, -0.25), Request::distance).signed_distance == Approx(-1.25));
}
