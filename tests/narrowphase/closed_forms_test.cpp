// Distances by formulas.
#include "closed_forms/closed_forms.h"
#include "closed_forms/surface_distance.h"

#include <cmath>

#include "catch.h"
#include "convex/gjk.h"
#include "random_pairs.h"
#include "reference.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("closed forms agree with the iterative solver, which shares no formula with them") {
  Random r(5);
  const NarrowPhase table;
  const NarrowPhase iterative({.tolerance = 0, .margin = 0, .solver = "gjk"});
  const std::pair<ShapeKind, ShapeKind> pairs[] = {
      {ShapeKind::sphere, ShapeKind::sphere},   {ShapeKind::sphere, ShapeKind::box},
      {ShapeKind::sphere, ShapeKind::capsule},  {ShapeKind::sphere, ShapeKind::cylinder},
      {ShapeKind::sphere, ShapeKind::cone},     {ShapeKind::sphere, ShapeKind::triangle},
      {ShapeKind::capsule, ShapeKind::capsule}, {ShapeKind::box, ShapeKind::box}};
  for (const auto& [ka, kb] : pairs)
    for (int i = 0; i < 300; ++i) {
      const Shape a = random_shape(ka, r), b = random_shape(kb, r);
      const Pose pa = random_pose(r, 0.6), pb = random_pose(r, 0.6);
      CAPTURE(name(ka), name(kb), i);
      const PairAnswer closed = table.solve(a, pa, b, pb, Request::distance);
      const PairAnswer other = iterative.solve(a, pa, b, pb, Request::distance);
      const bool smooth = kb == ShapeKind::cylinder || kb == ShapeKind::cone;
      CHECK(std::abs(closed.signed_distance - other.signed_distance) < (smooth ? 1e-7 : 1e-11));
    }
}

TEST_CASE("spheres: distance along the centres, a point is a sphere") {
  const NarrowPhase n;
  const auto answer =
      n.solve(Shape(Sphere{0}), Pose::at(1, 2, 3), Shape(Sphere{0}), Pose::at(1, 2, 3), Request::distance);
  CHECK(answer.collide);
  CHECK(answer.signed_distance == 0);
  CHECK(answer.normal.norm() == 1);
  const auto far = n.solve(Shape(Sphere{1}), Pose::at(0, 0, 0), Shape(Sphere{2}), Pose::at(3, 4, 0), Request::distance);
  CHECK(far.signed_distance == 2);
  CHECK(far.point_a.isApprox(Vec3(0.6, 0.8, 0), 1e-15));
  const double e = 1e-15;
  CHECK(n.solve(Shape(Sphere{1}), Pose::at(0, 0, 0), Shape(Sphere{1}), Pose::at(2, 0, 0), Request::collide).collide);
  CHECK_FALSE(
      n.solve(Shape(Sphere{1}), Pose::at(0, 0, 0), Shape(Sphere{1}), Pose::at(2 + 4 * e, 0, 0), Request::collide)
          .collide);
}

TEST_CASE("a sphere far from a triangle: as far as the triangle, not its plane") {
  const NarrowPhase n;
  const Shape sphere(Sphere{0.01}), triangle(Triangle{Vec3(0.5, 0.3, -92), Vec3(0, 0, -0.08), Vec3(0, -0.03, 0)});
  for (const double away : {1e3, 1e8, 1e15, 1e17, 1e26, 1e29})
    for (const Vec3& towards : {Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(0.6, 0, 0.8), Vec3(-0.48, 0.6, -0.64)}) {
      CAPTURE(away, towards.transpose());
      const PairAnswer r = n.solve(sphere, Pose{.rotation = Mat3::Identity(), .translation = away * towards}, triangle,
                                   Pose{}, Request::distance);
      CHECK(std::abs(r.signed_distance - away) <= 100 + 1e-15 * away);
      CHECK(r.normal.dot(-towards) > 0.99);
    }
}

TEST_CASE("a sphere a hair past a large triangle's edge: the way to the edge, not square to the plane") {
  // Equally far from the plane and the edge, to rounding; the position of the edge has seven more digits.
  const Shape triangle(Triangle{Vec3(0, 0, 0), Vec3(900, 0, 0), Vec3(0, 0, -300)});
  const double off = 1e-6;
  const Pose pose{.rotation = Mat3::Identity(), .translation = {400, 4, off}};
  const PairAnswer r = NarrowPhase().solve(Shape(Sphere{2}), pose, triangle, Pose{}, Request::distance);
  CHECK((r.point_b - r.point_a - r.signed_distance * r.normal).norm() < 1e-12);
  CHECK((r.normal - Vec3(0, -4, -off).normalized()).norm() < 1e-12);
}

TEST_CASE("a point on a segment, to rounding: the normal is square to the segment") {
  Random r(9);
  for (int i = 0; i < 100000; ++i) {
    const Vec3 from = r.direction(), to = from + r.in(0.1, 2) * r.direction();
    const Shape segment(Triangle{from, to, to});
    const Pose point{Mat3::Identity(), from + r.in(0.1, 0.9) * (to - from)};
    const PairAnswer answer = NarrowPhase().solve(Shape(Sphere{0}), point, segment, Pose{}, Request::distance);
    REQUIRE(std::abs(answer.normal.dot((to - from).normalized())) <= 1e-15);
  }
}

TEST_CASE("crossing capsules: depth is the radii, the normal their common perpendicular") {
  const NarrowPhase n;
  Pose turned;
  turned.rotation = Eigen::AngleAxisd(1.0, Vec3::UnitX()).toRotationMatrix();
  for (const double off : {0.0, 1e-14, -1e-9}) {
    turned.translation = {off, 0, 0};
    const auto answer = n.solve(Shape(Capsule{0.5, 4}), Pose{}, Shape(Capsule{0.25, 4}), turned, Request::distance);
    CHECK(std::abs(answer.signed_distance - (std::abs(off) - 0.75)) < 1e-15);
    CHECK(std::abs(std::abs(answer.normal.x()) - 1) < 1e-12);
  }
}

TEST_CASE("a capsule's end beside nearly the end of another: the normal is perpendicular to the one it is beside") {
  // At the common corner of two sides of the parameters the distance is the least of both, to rounding.
  Pose a, b;
  a.rotation << 0.99999999994393973, 3.4956310188854693e-06, -9.9950589387087719e-06, 3.4955722063367509e-06,
      -0.99999999997657874, -5.8841736871995011e-06, -9.9950795073747372e-06, 5.8841387484194063e-06,
      -0.99999999993273769;
  b.rotation << 0, 1, 0, 1, 0, 1.0150202309498847e-12, 1.0150202309498847e-12, 0, -1;
  b.translation = {-1.7582548182265565, -6.1461066745949794e-06, 1.7573896703384345e-05};
  const PairAnswer r = NarrowPhase().solve(Shape(Capsule{1.5, 1}), a, Shape(Capsule{0.25, 1}), b, Request::distance);
  CHECK(std::abs(r.normal.dot(a.rotation.col(2))) < 1e-15);

  Pose c;
  c.rotation << -9.5150088130960567e-11, 4.0843851071248217e-10, 1, 1, 4.3296921018851058e-09, 9.5150086362547576e-11,
      -4.3296921018462432e-09, 1, -4.0843851112445275e-10;
  const Pose ball = Pose::at(-1, 2, -1.75);
  const PairAnswer q =
      NarrowPhase().solve(Shape(Capsule{1.25, 2}), c, Shape(Capsule{1.375, 0}), ball, Request::distance);
  CHECK(std::abs(q.normal.dot(c.rotation.col(2))) < 1e-15);
}

TEST_CASE("nearly parallel capsules end to end: the distance of their ends") {
  // Rounding may put the feet of the common perpendicular of nearly parallel lines anywhere on the segments.
  Random r(1);
  for (int i = 0; i < 4000; ++i) {
    const double angle = std::pow(10, r.in(-13, -6)), gap = std::pow(10, r.in(-10, 0)),
                 radius = std::pow(10, r.in(-6, -1));
    const Capsule first{radius, r.in(0.5, 2)}, second{radius, r.in(0.5, 2)};
    const Pose a{r.rotation(), Vec3::Zero()};
    Pose b{a.rotation * Eigen::AngleAxisd(angle, Vec3::UnitY()).toRotationMatrix(), Vec3::Zero()};
    b.translation = a.rotation.col(2) * (first.length / 2 + gap) + b.rotation.col(2) * (second.length / 2);
    const PairAnswer answer = NarrowPhase().solve(Shape(first), a, Shape(second), b, Request::distance);
    CAPTURE(i, angle, gap, radius);
    CHECK(std::abs(answer.signed_distance - (gap - 2 * radius)) < 1e-12);
    CHECK(std::abs((answer.point_b - answer.point_a).norm() - std::abs(gap - 2 * radius)) < 1e-12);
  }
}

TEST_CASE("nearly parallel capsules: apart along the normal by the distance, their points opposite each other") {
  Random r(9);
  const auto length = [&] {
    if (r.once_in(4)) return std::pow(10, -r.in(0, 9));
    return r.in(0.1, 2);
  };
  for (int i = 0; i < 20000; ++i) {
    const double radius_a = length(), length_a = length(), radius_b = length(), length_b = length();
    const Shape a(Capsule{radius_a, length_a}), b(Capsule{radius_b, length_b});
    const Pose pose_a{r.rotation(), Vec3::Zero()};
    const Vec3 about = r.direction();
    Pose pose_b{Eigen::AngleAxisd(std::pow(10, -r.in(1, 12)), about) * pose_a.rotation, Vec3::Zero()};
    pose_b.translation = (radius_a + radius_b + 0.5 * (length_a + length_b)) * r.vec(-1, 1);
    if (r.once_in(3)) pose_b.translation = pose_a.rotation * Vec3(radius_a + radius_b, 0, (length_a + length_b) / 2);
    const PairAnswer answer = NarrowPhase().solve(a, pose_a, b, pose_b, Request::distance);
    const auto reach = [&](const Pose& pose, double radius, double along, const Vec3& n) {
      return n.dot(pose.translation) + radius + along / 2 * std::abs(n.dot(pose.rotation.col(2)));
    };
    const double apart =
        -reach(pose_b, radius_b, length_b, -answer.normal) - reach(pose_a, radius_a, length_a, answer.normal);
    const double unit = a.size() + b.size() + pose_b.translation.norm();
    CAPTURE(i, radius_a, length_a, radius_b, length_b, answer.signed_distance);
    CHECK(std::abs(apart - answer.signed_distance) < 2e-12 * unit);
    CHECK((answer.point_b - answer.point_a - answer.signed_distance * answer.normal).norm() < 3e-12 * unit);
  }
}

TEST_CASE("half-space with everything: the lowest point decides") {
  Random r(9);
  const NarrowPhase n;
  for (const ShapeKind k : bounded_convex)
    for (int i = 0; i < 50; ++i) {
      const Shape h = random_shape(ShapeKind::halfspace, r), s = random_shape(k, r);
      const Pose ph = random_pose(r, 1), ps = random_pose(r, 1);
      std::vector<Contact> contacts;
      const PairAnswer answer = n.solve(h, ph, s, ps, Request::contacts, &contacts);
      CAPTURE(name(k), i);
      CHECK(answer.normal.isApprox(ph.rotation * h.normal(), 1e-12));
      CHECK(contacts.empty() == !answer.collide);
      Pose moved = ps;
      moved.translation -= answer.signed_distance * answer.normal;  // now it touches
      CHECK(std::abs(n.solve(h, ph, s, moved, Request::distance).signed_distance) < 1e-14);
      double deepest = -1;
      for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
      if (answer.collide) CHECK(std::abs(deepest + answer.signed_distance) < 1e-9);
      CHECK(n.solve(s, ps, h, ph, Request::distance).normal == -answer.normal);
    }
}

TEST_CASE("a point on a cone's rim or apex, but for rounding: the normal parts the two") {
  reference::Random r(4);
  for (int i = 0; i < 3000; ++i) {
    const Cone cone{r.in(0.1, 1), r.in(0.1, 1)};
    const Pose pose{r.rotation(), r.vec(-1, 1)};
    const double angle = r.in(0, 6.28);
    const Vec3 rim{cone.radius * std::cos(angle), cone.radius * std::sin(angle), -0.5 * cone.length};
    const Pose at{Mat3::Identity(), pose * (r.once_in(4) ? Vec3(0, 0, 0.5 * cone.length) : rim)};
    const Shape a(cone), b(Sphere{0});
    const PairAnswer answer = NarrowPhase().solve(a, pose, b, at, Request::distance);
    REQUIRE(std::abs(answer.signed_distance) <= 1e-14);
    REQUIRE(std::abs(reference::separation(a, pose, b, at, answer.normal) - answer.signed_distance) <= 1e-14);
  }
}

TEST_CASE("a point below the rim of a cone's base is outside, at any angle and for the flattest cones") {
  reference::Random r(14);
  for (int i = 0; i < 3000; ++i) {
    const double radius = r.in(0.1, 1), angle = r.in(0, 6.28), below = radius * std::pow(10, r.in(-14, -9));
    const Cone cone{radius, radius * std::pow(10, r.in(-9, -7))};
    const Vec3 p(radius * std::cos(angle), radius * std::sin(angle), -0.5 * cone.length - below);
    const PointDistance d = point_distance(view(Shape(cone)), p);
    CAPTURE(i, radius, angle, below, cone.length);
    REQUIRE(std::abs(d.signed_distance - below) <= 4e-16 * radius);
    REQUIRE((p - d.nearest - d.signed_distance * d.normal).norm() <= 4e-16 * radius);
  }
}

TEST_CASE("capsules that cross, parallel but for rounding: the points are as far apart as the distance") {
  reference::Random r(5);
  for (int i = 0; i < 3000; ++i) {
    const Shape a(Capsule{0.25, r.in(0.1, 1)}), b(Capsule{0.1, r.in(0.1, 1)});
    const Pose pose{r.rotation(), Vec3::Zero()};
    const Vec3 across = pose.rotation.col(r.below(2));
    const Mat3 leaning = Eigen::AngleAxisd(r.in(1, 9) * 1e-10, across).toRotationMatrix();
    const double aside = r.in(0.1, 0.5);
    const Pose at{leaning * pose.rotation, aside * across + r.in(-0.05, 0.05) * pose.rotation.col(2)};
    const PairAnswer answer = NarrowPhase().solve(a, pose, b, at, Request::distance);
    REQUIRE((answer.point_b - answer.point_a - answer.signed_distance * answer.normal).norm() <= 1e-14);
  }
}

TEST_CASE("a line along a thin capsule or through a cone's apex, but for 1e-15 to 1e-3, leaves at the surface") {
  reference::Random r(15);
  for (int i = 0; i < 4000; ++i) {
    const bool is_cone = i % 2 == 0;
    const double radius = is_cone ? r.in(0.1, 1) : std::pow(10, r.in(-11, 0)), length = r.in(0.1, 1);
    const Shape shape = is_cone ? Shape(Cone{radius, length}) : Shape(Capsule{radius, length});
    const auto tiny = [&] { return r.sign() * std::pow(10, r.in(-15, -3)); };
    const double reach = is_cone ? 0.2 * radius : radius;
    const Vec3 p(0.5 * reach * tiny(), 0.5 * reach * tiny(), r.in(-0.4, 0.3) * length);
    const Vec3 d = Vec3(tiny(), tiny(), is_cone ? 1 : r.sign()).normalized();
    CAPTURE(i, radius, length, p.transpose(), d.transpose());
    const double exit = exit_length(view(shape), p, d);
    REQUIRE(std::abs(point_distance(view(shape), p + exit * d).signed_distance) <= 4e-15);
  }
}

TEST_CASE(
    "the distance of a point to a surface is as long as the least along any direction, and a line leaves where the "
    "surface is") {
  Random r(8);
  for (const ShapeKind kind : {ShapeKind::box, ShapeKind::capsule, ShapeKind::cylinder, ShapeKind::cone,
                               ShapeKind::ellipsoid, ShapeKind::convex})
    for (int i = 0; i < 200; ++i) {
      const Shape shape = random_shape(kind, r);
      const ConvexView v = view(shape);
      const auto support = [&](const Vec3& n) { return n.dot(core_support(v, n)) + core_radius(v); };
      // Between the centre and a point of the surface.
      const Vec3 edge = core_support(v, r.direction());
      Vec3 p = core_centre(v) + r.in(0, 0.99) * (edge - core_centre(v));
      // On a plane of symmetry the side is undetermined, deep inside not even whether it is the nearer one; near it
      // hardly.
      if (kind == ShapeKind::ellipsoid && i % 4 != 0) p[i % 3] = i % 4 == 1 ? 0 : i % 4 == 2 ? 1e-12 : -1e-160;
      CAPTURE(name(kind), i);
      const auto surface = surface_distance(v, p, 1e-9);
      if (!surface) continue;  // a flat hull
      CHECK(surface->inside);
      CHECK(surface->normal.norm() == Approx(1));
      CHECK(std::abs(support(surface->normal) - surface->normal.dot(p) + surface->distance) < 1e-12);
      for (int k = 0; k < 50; ++k) {
        const Vec3 d = r.direction();
        CHECK(support(d) - d.dot(p) >= -surface->distance - 1e-12);
        const Vec3 out = p + exit_length(v, p, d) * d;
        CHECK(std::abs(surface_distance(v, out, 0)->distance) < 1e-9);
        const auto beyond = surface_distance(v, out + 0.1 * d, 0);
        CHECK(!beyond->inside);
        CHECK(support(beyond->normal) - beyond->normal.dot(out + 0.1 * d) <= 1e-12);
      }
    }
}
