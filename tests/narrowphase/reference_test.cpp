// The reference that judges the solvers is judged by formulas and by an independent method: all candidate directions
// for polytopes, and a dense search over directions for round shapes.
#include "reference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "catch.h"
#include "judge.h"
#include "pair_classes.h"
#include "random.h"
#include "real.h"
#include "shapes/hull.h"
#include "shapes/hull_builder.h"
#include "shapes/shape_insides.h"

using namespace tandem;
using namespace tandem::reference;
using tandem::test::record;

namespace {

Pose at(double x, double y, double z) { return Pose::at(x, y, z); }

void check(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, double truth, double tolerance = 1e-15) {
  const PosedPair pair{a, pa, b, pb};
  INFO(record(pair));
  const Truth t = reference::signed_distance(a, pa, b, pb), swapped = reference::signed_distance(b, pb, a, pa);
  const double scale = std::max(1.0, reference::size(pair));
  CHECK(std::abs(t.signed_distance - truth) <= tolerance * scale);
  CHECK(std::abs(swapped.signed_distance - truth) <= tolerance * scale);
  CHECK(t.error <= 1e-14 * scale);
  CHECK(std::abs(reference::separation(a, pa, b, pb, t.normal) - truth) <= 1e-14 * scale);
}

// ---- the second method ----

struct Polytope {
  std::vector<Vec> vertices, normals;
  std::vector<std::array<Vec, 2>> edges;
};

Polytope polytope_at(const Shape& s, const Pose& pose, const Vec3& origin) {
  std::vector<Vec3> corners;
  if (s.kind() == ShapeKind::box) {
    for (int i = 0; i < 8; ++i)
      corners.push_back(s.half_size().cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  } else {
    corners = hull_of(s).vertices;
  }
  const Hull hull = build_hull(corners);
  const auto to_world = [&](const Vec3& v) {
    Vec p = Vec(pose.translation) - Vec(origin);
    for (int k = 0; k < 3; ++k) p += Real(v[k]) * Vec(Vec3(pose.rotation.col(k)));
    return p;
  };
  Polytope p;
  for (const Vec3& v : hull.vertices) p.vertices.push_back(to_world(v));
  for (const Hull::Face& f : hull.faces)
    for (std::uint32_t i = 0; i < f.count; ++i) {
      const auto corner = [&](std::uint32_t k) { return p.vertices[hull.loop[f.first + (i + k) % f.count]]; };
      p.normals.push_back(cross(corner(1) - corner(0), corner(2) - corner(0)));
    }
  for (const Hull::Edge& e : hull.edges) p.edges.push_back({p.vertices[e.v[0]], p.vertices[e.v[1]]});
  return p;
}

/// The largest separation over every direction that can be the best one: across faces, between edges, from corner to
/// corner and from corner to edge.
double brute_force(const Polytope& a, const Polytope& b) {
  Real best = -1e300;
  const auto attempt = [&](const Vec& direction) {
    const Real length = norm(direction);
    if (!(length > Real(1e-25))) return;
    Real top = -1e300, bottom = 1e300, low = 1e300, high = -1e300;
    for (const Vec& v : a.vertices) top = max(top, dot(direction, v)), bottom = min(bottom, dot(direction, v));
    for (const Vec& v : b.vertices) low = min(low, dot(direction, v)), high = max(high, dot(direction, v));
    best = max(best, max(low - top, bottom - high) / length);
  };
  const auto corner_edge = [&](const Polytope& p, const Polytope& q) {
    for (const Vec& v : p.vertices)
      for (const auto& [from, to] : q.edges) {
        const Vec along = to - from, d = v - from;
        attempt(d - (dot(along, d) / dot(along, along)) * along);
      }
  };
  for (const Vec& n : a.normals) attempt(n);
  for (const Vec& n : b.normals) attempt(n);
  for (const auto& e : a.edges)
    for (const auto& f : b.edges) attempt(cross(e[1] - e[0], f[1] - f[0]));
  for (const Vec& v : a.vertices)
    for (const Vec& w : b.vertices) attempt(w - v);
  corner_edge(a, b);
  corner_edge(b, a);
  return static_cast<double>(best);
}

/// The support of a round shape or a box along a unit direction, in its frame.
double extent(const Shape& s, const Vec3& n) {
  const double rho = std::hypot(n.x(), n.y());
  switch (s.kind()) {
    case ShapeKind::sphere:
      return s.radius();
    case ShapeKind::capsule:
      return s.radius() + 0.5 * s.length() * std::abs(n.z());
    case ShapeKind::cylinder:
      return s.radius() * rho + 0.5 * s.length() * std::abs(n.z());
    case ShapeKind::cone:
      return std::max(0.5 * s.length() * n.z(), s.radius() * rho - 0.5 * s.length() * n.z());
    case ShapeKind::ellipsoid:
      return s.radii().cwiseProduct(n).norm();
    case ShapeKind::box:
      return s.half_size().dot(n.cwiseAbs());
    default: {
      double most = -1e300;
      for (const Vec3& v : hull_of(s).vertices) most = std::max(most, v.dot(n));
      return most;
    }
  }
}

double separation_by_extents(const PosedPair& p, const Vec3& n) {
  return n.dot(p.pose_b.translation - p.pose_a.translation) - extent(p.a, p.pose_a.rotation.transpose() * n) -
         extent(p.b, -(p.pose_b.rotation.transpose() * n));
}

/// The largest separation over a lattice on the sphere, improved by ascent from the best. Ridges slow the ascent.
double search(const PosedPair& p) {
  const auto separation = [&](const Vec3& n) { return separation_by_extents(p, n); };
  std::vector<std::pair<double, Vec3>> tried;
  constexpr int samples = 4000;
  for (int i = 0; i < samples; ++i) {
    const double z = 1 - (2 * i + 1.0) / samples, rho = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vec3 n(rho * std::cos(angle), rho * std::sin(angle), z);
    tried.emplace_back(separation(n), n);
  }
  std::partial_sort(tried.begin(), tried.begin() + 12, tried.end(),
                    [](const auto& x, const auto& y) { return x.first > y.first; });
  double best = -1e300;
  for (int k = 0; k < 12; ++k) {
    auto [value, n] = tried[static_cast<std::size_t>(k)];
    Random r(static_cast<std::uint64_t>(k));
    for (double step = 0.05; step > 1e-7; step *= 0.8)
      for (int i = 0; i < 8; ++i) {
        const Vec3 m = (n + step * r.direction()).normalized();
        const double there = separation(m);
        if (there > value) value = there, n = m;
      }
    best = std::max(best, value);
  }
  return best;
}

}  // namespace

TEST_CASE("reference: pairs with a formula") {
  const Shape unit_sphere(Sphere{1}), box(Box{{2, 4, 6}}), cylinder(Cylinder{0.5, 3}), cone(Cone{1, 2}),
      capsule(Capsule{0.25, 2});
  check(unit_sphere, at(0, 0, 0), Shape(Sphere{2}), at(3, 4, 0), 2);
  check(unit_sphere, at(0, 0, 0), Shape(Sphere{2}), at(0, 0, 1), -2);
  check(unit_sphere, at(1, 1, 1), Shape(Sphere{2}), at(1, 1, 1), -3);
  check(Shape(Sphere{0}), at(0, 0, 0), Shape(Sphere{0}), at(0, 0, 0), 0);
  check(box, at(0, 0, 0), box, at(3, 0, 0), 1);
  check(box, at(0, 0, 0), box, at(3, 5, 0), std::sqrt(2.0));
  check(box, at(0, 0, 0), box, at(1.5, 1, 1), -0.5);
  check(box, at(0, 0, 0), box, at(0, 0, 0), -2);
  check(box, at(1e6, 1e6, -1e6), box, at(1e6 + 2, 1e6, -1e6), 0);
  check(box, at(0, 0, 0), unit_sphere, at(4, 6, 0), 4);
  check(box, at(0, 0, 0), unit_sphere, at(0.5, 0, 0), -1.5);
  check(cylinder, at(0, 0, 0), cylinder, at(0, 0, 2.75), -0.25);
  check(cylinder, at(0, 0, 0), cylinder, at(0, 0, 3.5), 0.5);
  check(cylinder, at(0, 0, 0), cylinder, at(1.5, 0, 1), 0.5);
  check(cylinder, at(0, 0, 0), cylinder, at(0.75, 0, 0), -0.25);
  check(cylinder, at(0, 0, 0), Shape(Sphere{0.125}), at(0.25, 0, 0), -0.375);
  check(cylinder, at(0, 0, 0), Shape(Sphere{0.125}), at(0.25, 0, 1.4), -0.225);
  check(cylinder, at(0, 0, 0), Shape(Sphere{1}), at(3.5, 0, 5.5), 4);
  check(cone, at(0, 0, 0), Shape(Sphere{0.5}), at(0, 0, 3), 1.5);
  check(cone, at(0, 0, 0), Shape(Sphere{0.5}), at(0, 0, -3), 1.5);
  check(cone, at(0, 0, 0), Shape(Sphere{0}), at(0, 0, 0), -1 / std::sqrt(5.0));
  check(capsule, at(0, 0, 0), capsule, at(1, 0, 0.5), 0.5);
  check(capsule, at(0, 0, 0), capsule, at(0, 0, 4), 1.5);
  check(capsule, at(0, 0, 0), {capsule}, {(Mat3() << 0, 0, 1, 0, 1, 0, -1, 0, 0).finished(), {0, 0.25, 0}}, -0.25);
  check(Shape(Ellipsoid{{1, 2, 3}}), at(0, 0, 0), Shape(Ellipsoid{{0.5, 1, 1}}), at(0, 0, 0), -1.5);
  check(Shape(Ellipsoid{{1, 2, 3}}), at(0, 0, 0), Shape(Ellipsoid{{0.5, 1, 1}}), at(0, 0, 5), 1);
  check(Shape(HalfSpace{{0, 0, 2}, 2}), at(0, 0, 5), box, at(7, 7, 8), -1);
  check(Shape(HalfSpace{{0, 0, 2}, 2}), at(0, 0, 5), cone, at(7, 7, 8), 1);
  const Shape triangle(Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}});
  check(triangle, at(0, 0, 0), triangle, at(0, 0, 0.5), 0.5);
  check(triangle, at(0, 0, 0), triangle, at(0.25, 0.25, 0), 0);
  check(triangle, at(0, 0, 0), triangle, at(2, 0, 0), 1);
  check(triangle, at(0, 0, 0), Shape(Sphere{0.5}), at(0.25, 0.25, 0.25), -0.25);
}

TEST_CASE("reference: round shapes about one axis, where every direction across is as good") {
  check(Shape(Cylinder{0.5, 3}), at(0, 0, 0), Shape(Cylinder{0.25, 4}), at(0, 0, 0.5), -0.75, 1e-14);
  check(Shape(Cylinder{0.5, 1}), at(0, 0, 0), Shape(Cylinder{0.5, 1}), at(0, 0, 0), -1, 1e-14);
  check(Shape(Cone{1, 2}), at(0, 0, 0), Shape(Cylinder{1, 8}), at(0, 0, 0), -2, 1e-14);
  check(Shape(Ellipsoid{{1, 1, 5}}), at(0, 0, 0), Shape(Ellipsoid{{2, 2, 7}}), at(0, 0, 0), -3, 1e-14);
}

TEST_CASE("reference: boxes, triangles and hulls against every direction that can be the best") {
  const ShapeRecipe kinds[] = {{ShapeKind::box}, {ShapeKind::triangle}, {ShapeKind::convex, 8}};
  for (const ShapeRecipe& a : kinds)
    for (const ShapeRecipe& b : kinds)
      for (const PairClass c : all_pair_classes)
        for (std::uint64_t i = 0; i < 8; ++i) {
          const PosedPair p = make_pair(a, b, c, i);
          INFO(record(p));
          const Truth t = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
          const Vec3& origin = p.pose_a.translation;
          const double second = brute_force(polytope_at(p.a, p.pose_a, origin), polytope_at(p.b, p.pose_b, origin));
          CHECK(std::abs(t.signed_distance - second) <= 1e-15 * reference::size(p));
          CHECK(t.error <= 1e-15 * reference::size(p));
        }
}

TEST_CASE("reference: round shapes against a search over directions") {
  const ShapeKind kinds[] = {ShapeKind::cylinder, ShapeKind::cone,   ShapeKind::ellipsoid,
                             ShapeKind::capsule,  ShapeKind::sphere, ShapeKind::box};
  for (const ShapeKind a : {ShapeKind::cylinder, ShapeKind::cone, ShapeKind::ellipsoid})
    for (const ShapeKind b : kinds)
      for (const PairClass c : {PairClass::separated, PairClass::near, PairClass::shallow, PairClass::deep})
        for (std::uint64_t i = 0; i < 2; ++i) {
          const PosedPair p = make_pair({a}, {b}, c, i);
          INFO(record(p));
          const Truth t = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
          const double second = search(p);
          CHECK(second <= t.signed_distance + t.error + 1e-15 * reference::size(p));
          CHECK(second >= t.signed_distance - 1e-3 * reference::size(p));
          CHECK(std::abs(separation_by_extents(p, t.normal) - t.signed_distance) <= 1e-14 * reference::size(p));
          CHECK(t.error <= 1e-14 * reference::size(p));
        }
}
