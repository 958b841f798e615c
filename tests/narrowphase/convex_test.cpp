// Every bounded convex kind with every other, judged by properties that a signed distance must have.
#include <algorithm>
#include <cmath>

#include "catch.h"
#include "closed_forms/closed_forms.h"
#include "random_pairs.h"
#include "reference.h"
#include "shapes/hull.h"
#include "shapes/shape_insides.h"
#include "shapes/support.h"

using namespace tandem;
using namespace tandem::test;

namespace {

/// The separation along a unit direction from A to B, by supports alone: never more than the signed distance, and equal
/// to it along the right normal. Shares only the supports with the solvers.
double separation(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, const Vec3& n) {
  const ConvexView va = view(a), vb = view(b);
  const Vec3 sa = pa.rotation * core_support(va, pa.rotation.transpose() * n);
  const Vec3 sb = pb.rotation * core_support(vb, -(pb.rotation.transpose() * n));
  return n.dot((pb.translation - pa.translation) + (sb - sa)) - core_radius(va) - core_radius(vb);
}

/// The largest separation over all directions, by ascent from many starts.
double best_separation(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, Random& r) {
  double best = -1e300;
  for (int start = 0; start < 60; ++start) {
    Vec3 n = r.direction();
    double s = separation(a, pa, b, pb, n);
    for (double step = 0.5; step > 1e-4; step *= 0.6)
      for (int k = 0; k < 6; ++k) {
        const Vec3 m = (n + step * r.direction()).normalized();
        const double t = separation(a, pa, b, pb, m);
        if (t > s) s = t, n = m;
      }
    best = std::max(best, s);
  }
  return best;
}

double accuracy_of(const Shape& a, const Shape& b) {
  const auto round = [](ShapeKind k) {
    return k == ShapeKind::cylinder || k == ShapeKind::cone || k == ShapeKind::ellipsoid;
  };
  return round(a.kind()) || round(b.kind()) ? 1e-6 : 1e-9;
}

/// The distance of a point in world coordinates from the surface of a shape.
double off_surface(const Shape& s, const Pose& pose, const Vec3& world) {
  const Vec3 p = pose.rotation.transpose() * (world - pose.translation);
  if (s.kind() == ShapeKind::ellipsoid) {
    const double f = p.cwiseQuotient(s.radii()).norm();
    return std::abs(f - 1) * f / p.cwiseQuotient(s.radii().cwiseProduct(s.radii())).norm();
  }
  if (s.kind() == ShapeKind::convex) {
    double out = -1e300;
    for (const Hull::Face& face : hull_of(s).faces) out = std::max(out, face.normal.dot(p) - face.offset);
    return std::abs(out);
  }
  return std::abs(point_distance(view(s), p).signed_distance);
}

/// Checks the answer's two points against their documentation.
void check_points(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, double eps) {
  const PairAnswer answer = NarrowPhase().solve(a, pa, b, pb, Request::distance);
  CAPTURE(answer.signed_distance, answer.normal.transpose(), answer.point_a.transpose(), answer.point_b.transpose());
  CHECK((answer.point_b - answer.point_a - answer.signed_distance * answer.normal).norm() < eps);
  CHECK(off_surface(a, pa, answer.point_a) < eps);
  CHECK(off_surface(b, pb, answer.point_b) < eps);
}

}  // namespace

TEST_CASE("convex: the witness points lie on both surfaces, the signed distance apart along the normal") {
  Random r(31);
  // Also half turns and aligned poses: parallel edges and faces, where many points are equally deep.
  const auto aligned = [&] {
    Mat3 m = Mat3::Identity();
    for (int k = 0; k < 3; ++k)
      if (r.unit() < 0.5) m = Eigen::AngleAxisd(0.5 * M_PI, Vec3::Unit(k)).toRotationMatrix() * m;
    return m;
  };
  std::vector<ShapeKind> kinds(std::begin(bounded_convex), std::end(bounded_convex));
  kinds.push_back(ShapeKind::halfspace);
  for (const ShapeKind ka : kinds)
    for (const ShapeKind kb : kinds) {
      if (ka == ShapeKind::halfspace && kb == ShapeKind::halfspace) continue;
      for (int i = 0; i < 60; ++i) {
        const Shape a = random_shape(ka, r), b = random_shape(kb, r);
        Pose pa = random_pose(r, 0.5), pb = random_pose(r, i % 2 == 0 ? 0.5 : 1.2);
        CAPTURE(name(ka), name(kb), i);
        check_points(a, pa, b, pb, 2 * accuracy_of(a, b));
        // The same with parallel faces and edges, in a rotated world, and tilted by tiny angles.
        pb.rotation = pa.rotation * aligned();
        check_points(a, pa, b, pb, 2 * accuracy_of(a, b));
        pb.rotation = pb.rotation * Eigen::AngleAxisd{std::pow(10.0, r.in(-16, -3)), r.direction()}.toRotationMatrix();
        check_points(a, pa, b, pb, 2 * accuracy_of(a, b));
      }
    }
}

TEST_CASE("convex: the normal certifies the distance, no direction separates better") {
  Random r(7);
  const NarrowPhase solver;
  int apart = 0, touching = 0;
  for (const ShapeKind ka : bounded_convex)
    for (const ShapeKind kb : bounded_convex)
      for (int i = 0; i < 40; ++i) {
        const Shape a = random_shape(ka, r), b = random_shape(kb, r);
        const Pose pa = random_pose(r, 0.5), pb = random_pose(r, i % 2 == 0 ? 0.5 : 1.2);
        CAPTURE(name(ka), name(kb), i);
        const PairAnswer answer = solver.solve(a, pa, b, pb, Request::distance);
        const double eps = accuracy_of(a, b);
        REQUIRE(std::abs(answer.normal.norm() - 1) < 1e-12);
        CHECK(std::abs(separation(a, pa, b, pb, answer.normal) - answer.signed_distance) < eps);
        CHECK(answer.signed_distance > best_separation(a, pa, b, pb, r) - eps);
        CHECK((answer.point_b - answer.point_a - answer.signed_distance * answer.normal).norm() < 1e-6);
        CHECK(answer.collide == (answer.signed_distance <= 0));
        CHECK(solver.solve(a, pa, b, pb, Request::collide).collide == answer.collide);
        if (answer.status != Status::ok) CHECK(answer.error_bound < 1e-5);
        ++(answer.collide ? touching : apart);

        const PairAnswer swapped = solver.solve(b, pb, a, pa, Request::distance);
        CHECK(std::abs(swapped.signed_distance - answer.signed_distance) < eps);
        if (ka != kb) CHECK(swapped.normal == -answer.normal);

        // A translation of B by the depth along the normal separates, one by 0.99 of it does not.
        if (answer.signed_distance < -1e-4) {
          Pose moved = pb;
          moved.translation -= (1.0001 * answer.signed_distance) * answer.normal;
          CHECK_FALSE(solver.solve(a, pa, b, moved, Request::collide).collide);
          moved.translation = pb.translation - 0.99 * answer.signed_distance * answer.normal;
          CHECK(solver.solve(a, pa, b, moved, Request::collide).collide);
        }
        // A rigid motion of both changes nothing; far from the origin it costs digits of the input only.
        const Pose q = random_pose(r, 10);
        const Pose qa{q.rotation * pa.rotation, q * pa.translation}, qb{q.rotation * pb.rotation, q * pb.translation};
        CHECK(std::abs(solver.solve(a, qa, b, qb, Request::distance).signed_distance - answer.signed_distance) < eps);
      }
  CHECK(apart > 500);
  CHECK(touching > 500);
}

TEST_CASE("convex: gaps of 1e-12 to 1e-3 of either sign are seen as such") {
  Random r(11);
  const NarrowPhase solver;
  for (const ShapeKind ka : bounded_convex)
    for (const ShapeKind kb : bounded_convex)
      for (int i = 0; i < 30; ++i) {
        const Shape a = random_shape(ka, r), b = random_shape(kb, r);
        const Pose pa = random_pose(r, 0.1);
        Pose pb = random_pose(r, 1.0);
        pb.translation += 2 * pb.translation.normalized();
        const PairAnswer far = solver.solve(a, pa, b, pb, Request::distance);
        REQUIRE(far.signed_distance > 0);
        pb.translation -= far.signed_distance * far.normal;  // now they touch
        const double gap = std::pow(10.0, r.in(-12, -3)) * (i % 2 == 0 ? 1 : -1);
        if (gap < 0 && std::abs(gap) > 1e-6) continue;  // deeper, another direction may be shorter
        pb.translation += gap * far.normal;
        CAPTURE(name(ka), name(kb), i, gap);
        const PairAnswer near = solver.solve(a, pa, b, pb, Request::distance);
        const bool collide = solver.solve(a, pa, b, pb, Request::collide).collide;
        const double eps = std::max(accuracy_of(a, b) * 1e-3, 1e-12);
        if (gap > 0) {
          CHECK(std::abs(near.signed_distance - gap) < eps);
          if (gap > eps) CHECK_FALSE(collide);
        } else {
          // A corner moved in may be nearer to another face; a sharp one may be passed.
          CHECK(near.signed_distance > gap - eps);
          if (near.signed_distance < -eps) {
            CHECK(collide);
          } else {
            const reference::Truth truth = reference::signed_distance(a, pa, b, pb);
            CHECK(std::abs(near.signed_distance - truth.signed_distance) < eps);
          }
        }
      }
}

TEST_CASE("convex: identical poses, concentric shapes, needles, plates, flat hulls and points are answered") {
  std::vector<Shape> shapes;
  Random r(3);
  for (const ShapeKind k : bounded_convex) shapes.push_back(random_shape(k, r));
  shapes.emplace_back(Sphere{0});
  shapes.emplace_back(Box{{1e-4, 1, 1}});
  shapes.emplace_back(Box{{1e-4, 1e-4, 1}});
  shapes.emplace_back(Capsule{0.3, 0});
  shapes.emplace_back(Cylinder{1, 1e-4});
  shapes.emplace_back(Cone{1e-4, 1});
  shapes.emplace_back(Ellipsoid{{1e-3, 1, 1}});
  shapes.emplace_back(Convex{{{0.1, 0.2, 0.3}}});
  shapes.emplace_back(Convex{{{-1, 0, 0}, {1, 0, 0}}});
  shapes.emplace_back(Convex{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}});
  shapes.emplace_back(Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(2, 0, 0)}});
  const NarrowPhase solver;
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = 0; j < shapes.size(); ++j)
      for (const Vec3& t : {Vec3(0, 0, 0), Vec3(0, 0, 1e-9), Vec3(0.5, 0, 0), Vec3(0, 1e3, 0)}) {
        CAPTURE(i, j, t.transpose());
        const Pose pa, pb{Mat3::Identity(), t};
        std::vector<Contact> contacts;
        const PairAnswer answer = solver.solve(shapes[i], pa, shapes[j], pb, Request::contacts, &contacts);
        REQUIRE(std::isfinite(answer.signed_distance));
        REQUIRE(std::abs(answer.normal.norm() - 1) < 1e-9);
        REQUIRE(answer.point_a.allFinite());
        REQUIRE(answer.point_b.allFinite());
        CHECK(std::abs(separation(shapes[i], pa, shapes[j], pb, answer.normal) - answer.signed_distance) < 1e-6);
        CHECK(contacts.size() <= 4);
        CHECK(contacts.empty() == !answer.collide);
        for (const Contact& c : contacts) {
          CHECK(c.point.allFinite());
          CHECK(c.depth >= 0);
          CHECK(c.depth <= -answer.signed_distance + 1e-9);
        }
        if (t.y() > 100) CHECK(answer.signed_distance > 900);
      }
}
