// Tests single depth solvers directly: what they miss need not show in a pair's answer, since failures are solved
// another way.
#include <cmath>

#include "catch.h"
#include "convex/exact_polytope.h"
#include "convex/face_depth.h"
#include "random_pairs.h"
#include "round/support_descent.h"
#include "shapes/hull_builder.h"
#include "shapes/shape_insides.h"

using namespace tandem;
using namespace tandem::test;

namespace {

Hull corners_of(const Shape& s) {
  if (s.kind() != ShapeKind::box) return hull_of(s);
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(s.half_size().cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  return build_hull(corners);
}

/// The least support of A - B along any direction that can be the least translation: face normals, cross products of
/// edges.
double least_reach(const Hull& a, const Hull& b, const RelativePose& pose) {
  std::vector<Vec3> at_b;
  for (const Vec3& v : b.vertices) at_b.push_back(pose.rotation * v + pose.translation);
  double least = infinity;
  const auto along = [&](const Vec3& n) {
    const double length = n.norm();
    if (!(length > 1e-12)) return;
    double high_a = -infinity, low_a = infinity, high_b = -infinity, low_b = infinity;
    for (const Vec3& v : a.vertices) high_a = std::max(high_a, n.dot(v)), low_a = std::min(low_a, n.dot(v));
    for (const Vec3& v : at_b) high_b = std::max(high_b, n.dot(v)), low_b = std::min(low_b, n.dot(v));
    least = std::min({least, (high_a - low_b) / length, (high_b - low_a) / length});
  };
  for (const Hull::Face& f : a.faces) along(f.normal);
  for (const Hull::Face& f : b.faces) along(pose.rotation * f.normal);
  for (const Hull::Edge& e : a.edges)
    for (const Hull::Edge& f : b.edges)
      along((a.vertices[e.v[1]] - a.vertices[e.v[0]]).cross(at_b[f.v[1]] - at_b[f.v[0]]));
  return least;
}

}  // namespace

TEST_CASE("depth by faces is the least over all normals of faces and products of edges") {
  Random r(61);
  const auto shape = [&r](int i) {
    if (i % 3 == 0) return Shape(Box{r.vec(0.3, 1.5)});
    Convex c;
    const int points = i % 3 == 1 ? 4 + i % 7 : 32;
    for (int k = 0; k < points; ++k) c.vertices.push_back(0.7 * r.direction());
    return Shape(c);
  };
  int found = 0, by_edges = 0;
  for (int i = 0; i < 240; ++i) {
    const Shape a = shape(i), b = shape(i / 3);
    const ConvexView view_a = view(a), view_b = view(b);
    Pose pose_b = random_pose(r, 0.15);
    if (i % 16 == 0) pose_b.rotation = Mat3::Identity();
    const MinkowskiDifference d{view_a, view_b, relative(Pose{}, pose_b)};
    LocalAnswer answer;
    if (!depth_by_faces(d, answer)) continue;
    ++found;
    const Hull hull_a = corners_of(a), hull_b = corners_of(b);
    const double truth = least_reach(hull_a, hull_b, d.pose);
    CAPTURE(i, name(a.kind()), name(b.kind()), truth);
    CHECK(std::abs(-answer.signed_distance - truth) <= 1e-14 * d.scale());
    CHECK(std::abs(answer.normal.dot(d.support(answer.normal).w) - truth) <= 1e-14 * d.scale());
    CHECK((answer.point_a - answer.point_b - truth * answer.normal).norm() <= 1e-12 * d.scale());
    const auto outside = [](const Hull& hull, const Vec3& p) {
      double out = 0;
      for (const Hull::Face& f : hull.faces) out = std::max(out, f.normal.dot(p) - f.offset);
      return out;
    };
    CHECK(outside(hull_a, answer.point_a) <= 1e-12 * d.scale());
    CHECK(outside(hull_b, d.pose.rotation.transpose() * (answer.point_b - d.pose.translation)) <= 1e-12 * d.scale());
    double by_face = infinity;
    for (const Hull::Face& f : hull_a.faces) by_face = std::min(by_face, f.normal.dot(d.support(f.normal).w));
    for (const Hull::Face& f : hull_b.faces) {
      const Vec3 n = -(d.pose.rotation * f.normal);
      by_face = std::min(by_face, n.dot(d.support(n).w));
    }
    by_edges += by_face > truth + 1e-6 ? 1 : 0;
  }
  CHECK(found > 150);
  CHECK(by_edges > 20);
}

TEST_CASE("the exact polytope has the least depth of all normals, however much smaller or thinner one shape is") {
  Random r(63);
  const auto points = [&r](int count, double size, double thickness) {
    Convex c;
    for (int k = 0; k < count; ++k) c.vertices.push_back(size * r.vec(-1, 1).cwiseProduct(Vec3(1, 1, thickness)));
    return Shape(c);
  };
  const auto small = [&r](double most) { return std::pow(10.0, -r.in(0, most)); };
  int found = 0;
  for (int i = 0; i < 1500; ++i) {
    const double size = i % 2 == 0 ? 1 : small(8), thickness = i % 3 == 0 ? small(9) : 1;
    const int count = 2 + i % 11;
    const Shape a = points(4 + i % 12, 1, 1), b = points(count, size, thickness);
    const ConvexView view_a = view(a), view_b = view(b);
    const MinkowskiDifference d{view_a, view_b, relative(Pose{}, random_pose(r, i % 5 == 0 ? 0 : 0.3))};
    EpaResult e;
    CAPTURE(i, size, thickness, count);
    REQUIRE(expand_exactly(d, e));
    const double least = least_reach(corners_of(a), corners_of(b), d.pose);
    CHECK(std::abs(e.normal.dot(d.support(e.normal).w) - e.upper) <= 4 * epsilon * d.scale());
    if (!(least > 0)) continue;  // separated: the upper bound is that along some normal
    ++found;
    CHECK(e.upper <= least + 1e-14 * d.scale());
    CHECK(e.lower >= e.upper - 16 * epsilon * d.scale());
  }
  CHECK(found > 700);
}

TEST_CASE("a cube and a tetrahedron that touch 1.6 km from their own origins have points on them") {
  // There supports are less exact than the offsets of the exact polytope's faces, and below them all.
  const Vec3 corner(941.41662498256073, -939.83771617656646, 916.94191929372505);
  Convex cube;
  for (int k = 0; k < 8; ++k) cube.vertices.push_back(corner + Vec3(k & 1 ? 1 : 0, k & 2 ? 1 : 0, k & 4 ? 1 : 0));
  const Shape a(cube), b(Convex{{{1310.3374703645268, 170.46149856463094, -930.19454922160321},
                                 {1310.6491867154289, 170.65769146478038, -930.83868061861506},
                                 {1310.9815729861209, 169.78292035461294, -929.89972366654001},
                                 {1310.7014796162857, 170.77373603614208, -930.90429225654873}}});
  Pose pose;
  pose.rotation << 0.090333585151693541, -0.31834109567637309, -0.94366243445270614, -0.9106019378237411,
      0.35730049133666975, -0.20770283994741645, 0.40329140112986461, 0.87806338364274172, -0.25760578425293512;
  pose.translation = {0.52840328767367151, 0.13831030067531469, 0.60661074569379014};
  const PairAnswer r = NarrowPhase().solve(a, {}, b, pose, Request::distance);
  const Vec3 half = Vec3::Constant(0.5), beside = (r.point_a - corner - half).cwiseAbs() - half;
  CHECK(beside.maxCoeff() < 1e-9);
  CHECK((r.point_a - r.point_b).norm() < 1e-9);
}

TEST_CASE("settling by itself reaches the distance, and from inside the minimum that it starts near") {
  Random r(62);
  constexpr ShapeKind round[] = {ShapeKind::cylinder, ShapeKind::cone, ShapeKind::ellipsoid};
  int apart = 0, deep = 0;
  for (int i = 0; i < 400; ++i) {
    const Shape a = random_shape(round[i % 3], r), b = random_shape(bounded_convex[i / 3 % 8], r);
    const ConvexView view_a = view(a), view_b = view(b);
    const MinkowskiDifference d{view_a, view_b, relative(Pose{}, random_pose(r, i % 2 == 0 ? 1.5 : 0.3))};
    const RoundPair pair(d);
    Vec3 n = r.direction();
    const Support descended = minimize(pair, n, -infinity);
    n = (descended.n + (descended.h > 0 ? 1e-3 : 0.3) * n).normalized();
    const double start = n.dot(pair.support(n));
    const Support s = settle(pair, n, -infinity);
    CAPTURE(i, name(a.kind()), name(b.kind()), start, descended.h, s.h);
    CHECK(s.h <= start + 1e-13 * pair.scale);
    CHECK(std::abs(s.h - s.n.dot(pair.support(s.n))) <= 1e-13 * pair.scale);
    if (s.h < 0) {
      ++apart;
      // The points are at least as far apart as the bodies, which are at least as far as the planes: both are the
      // distance.
      CHECK((s.point[0] + s.point[1]).norm() + s.h <= 1e-9 * pair.scale);
    } else {
      ++deep;
      CHECK(s.h <= descended.h + 1e-9 * pair.scale);
      CHECK(start - s.h >= 0.9 * (start - descended.h));
      CHECK((s.point[0] + s.point[1] - s.h * s.n).norm() <= 1e-4 * pair.scale);
    }
  }
  CHECK(apart > 100);
  CHECK(deep > 100);
}
