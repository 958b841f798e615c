// Boxes, hulls and triangles in hard positions, judged in extended precision by the separation along the normal, and
// for overlaps by every direction that can be the least translation: face normals and cross products of edges.
#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.h"
#include "random_pairs.h"
#include "shapes/hull.h"
#include "shapes/hull_builder.h"
#include "shapes/shape_insides.h"

using namespace tandem;
using namespace tandem::test;

namespace {

using Real = long double;
using Real3 = std::array<Real, 3>;

Real dot(const Real3& a, const Real3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Real3 cross(const Real3& a, const Real3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A polytope in the world, relative to the first shape's translation.
struct Posed {
  std::vector<Real3> vertices, normals, edges;
};

Hull polytope_of(const Shape& s) {
  if (s.kind() != ShapeKind::box) return hull_of(s);
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(s.half_size().cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  return build_hull(corners);
}

Posed posed(const Shape& s, const Pose& pose, const Vec3& origin) {
  const Hull hull = polytope_of(s);
  Posed p;
  for (const Vec3& v : hull.vertices) {
    Real3 w;
    for (int i = 0; i < 3; ++i) {
      Real sum = static_cast<Real>(pose.translation[i]) - origin[i];
      for (int j = 0; j < 3; ++j) sum += static_cast<Real>(pose.rotation(i, j)) * v[j];
      w[static_cast<std::size_t>(i)] = sum;
    }
    p.vertices.push_back(w);
  }
  const auto minus = [&](std::uint32_t i, std::uint32_t j) {
    const Real3 &a = p.vertices[i], &b = p.vertices[j];
    return Real3{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  };
  for (const Hull::Edge& e : hull.edges) p.edges.push_back(minus(e.v[1], e.v[0]));
  for (const Hull::Face& f : hull.faces) {
    const std::uint32_t* l = &hull.loop[f.first];
    p.normals.push_back(cross(minus(l[1], l[0]), minus(l[2], l[0])));
  }
  return p;
}

/// The separation along n, of any length but 0; minus infinity for 0.
Real separation(const Posed& a, const Posed& b, const Real3& n) {
  const Real length = std::sqrt(dot(n, n));
  if (!(length > 0)) return -std::numeric_limits<Real>::infinity();
  Real hi = -std::numeric_limits<Real>::infinity(), lo = -hi;
  for (const Real3& v : a.vertices) hi = std::max(hi, dot(n, v));
  for (const Real3& v : b.vertices) lo = std::min(lo, dot(n, v));
  return (lo - hi) / length;
}

/// The largest separation along a face normal or a cross product of edges.
Real best_separation(const Posed& a, const Posed& b) {
  Real best = -std::numeric_limits<Real>::infinity();
  const auto both = [&](const Real3& n) {
    best = std::max({best, separation(a, b, n), separation(a, b, {-n[0], -n[1], -n[2]})});
  };
  for (const Real3& n : a.normals) both(n);
  for (const Real3& n : b.normals) both(n);
  for (const Real3& e : a.edges)
    for (const Real3& f : b.edges) {
      // Nearly parallel edges give an arbitrary direction: a valid bound, but no requirement.
      const Real3 n = cross(e, f);
      if (dot(n, n) > 1e-24L * dot(e, e) * dot(f, f)) both(n);
    }
  return best;
}

constexpr double worst = 1e-13;  ///< permitted error, relative to the sizes
constexpr double usual = 1e-14;  ///< permitted in 99 of 100 pairs

struct Tally {
  int pairs = 0, unusual = 0;
};

void check(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, Tally& tally) {
  if (a.kind() == ShapeKind::box && b.kind() == ShapeKind::box) return;  // these have their own solver
  const NarrowPhase solver;
  const PairAnswer answer = solver.solve(a, pa, b, pb, Request::distance);
  const double size = a.size() + b.size();
  const Posed qa = posed(a, pa, pa.translation), qb = posed(b, pb, pa.translation);
  const Vec3 n = answer.normal;
  CAPTURE(name(a.kind()), name(b.kind()), a.size(), b.size(), answer.signed_distance, n.transpose());
  CHECK(answer.status == Status::ok);
  CHECK(std::abs(n.norm() - 1) < 1e-14);
  const auto along = static_cast<double>(separation(qa, qb, {n[0], n[1], n[2]}));
  double error = std::abs(along - answer.signed_distance);
  // Far from the origin the points have the rounding of their coordinates.
  const double world = worst * size + 4e-16 * (pa.translation.norm() + pb.translation.norm());
  CHECK((answer.point_b - answer.point_a - answer.signed_distance * n).norm() <= world);
  const bool collide = solver.solve(a, pa, b, pb, Request::collide).collide;
  CHECK(collide == answer.collide);
  if (answer.signed_distance < 0) {
    const auto best = static_cast<double>(best_separation(qa, qb));
    error = std::max(error, std::abs(answer.signed_distance - best));
  }
  CHECK(error <= worst * size);
  ++tally.pairs;
  tally.unusual += error > usual * size ? 1 : 0;
  const PairAnswer other = solver.solve(b, pb, a, pa, Request::distance);
  if (a.kind() == b.kind()) {
    CHECK(other.signed_distance == answer.signed_distance);
    const bool same = pa.translation == pb.translation && pa.rotation == pb.rotation;
    if (!same) CHECK(other.normal == -answer.normal);
    CHECK(solver.solve(b, pb, a, pa, Request::collide).collide == collide);
  } else {
    CHECK(std::abs(other.signed_distance - answer.signed_distance) <= worst * size);
  }
}

Shape random_polytope(Random& r, double size) {
  switch (static_cast<int>(r.in(0, 5))) {
    case 0:
      return Shape(Box{size * r.vec(0.3, 1)});
    case 1:
      return Shape(Triangle{{size * r.vec(-0.5, 0.5), size * r.vec(-0.5, 0.5), size * r.vec(-0.5, 0.5)}});
    default: {
      // A ball, a needle, a plate, or a flat one.
      Vec3 axes = Vec3::Ones();
      const int form = static_cast<int>(r.in(0, 6));
      if (form == 3) axes = {1, 1e-4, 1e-4};
      if (form == 4) axes = {1, 1e-4, 1};
      if (form == 5) axes = {1, 1, 0};
      Convex c;
      const int n = 4 + static_cast<int>(r.in(0, 12));
      for (int i = 0; i < n; ++i) c.vertices.push_back(0.5 * size * r.direction().cwiseProduct(axes));
      return Shape(c);
    }
  }
}

}  // namespace

TEST_CASE("polytopes: apart, nearly touching, shallow and deep, of any form and ratio of sizes") {
  Random r(31);
  Tally tally;
  const NarrowPhase solver;
  for (int i = 0; i < 1500; ++i) {
    const Shape a = random_polytope(r, 1), b = random_polytope(r, i % 5 == 0 ? std::pow(10.0, r.in(-4, 0)) : 1);
    const Pose pa = random_pose(r, i % 7 == 0 ? 1e5 : 1);
    Pose pb = random_pose(r, 0.2);
    CAPTURE(i);
    pb.translation += pa.translation;
    check(a, pa, b, pb, tally);
    pb.translation = pa.translation + 3 * r.direction();
    const PairAnswer far = solver.solve(a, pa, b, pb, Request::distance);
    const double sign = r.unit() < 0.5 ? 1 : -1;
    for (const double gap : {0.1, std::pow(10.0, r.in(-12, -3)) * sign, -std::pow(10.0, r.in(-6, -2))}) {
      Pose near = pb;
      near.translation -= (far.signed_distance - gap * (a.size() + b.size())) * far.normal;
      CAPTURE(gap);
      check(a, pa, b, near, tally);
    }
  }
  CHECK(tally.unusual <= tally.pairs / 100);
}

TEST_CASE("polytopes: identical, concentric and aligned ones, faces on faces and edges on edges") {
  Random r(37);
  Tally tally;
  for (int i = 0; i < 400; ++i) {
    const Shape a = random_polytope(r, 1);
    const Shape b = i % 2 == 0 ? a : random_polytope(r, 1);
    const Pose pa = random_pose(r, 1);
    CAPTURE(i);
    check(a, pa, b, pa, tally);
    for (const double step : {0.3, 1e-3, 1e-9, 1e-15})
      for (int k = 0; k < 3; ++k) {
        Pose pb = pa;
        pb.translation += step * pa.rotation.col(k);
        CAPTURE(step, k);
        check(a, pa, b, pb, tally);
      }
    // Moved along its own edges and faces: they stay in contact.
    const Hull hull = polytope_of(a);
    for (std::size_t e = 0; e < std::min<std::size_t>(hull.edges.size(), 4); ++e) {
      Pose pb = pa;
      pb.translation += pa.rotation * (0.5 * (hull.vertices[hull.edges[e].v[1]] - hull.vertices[hull.edges[e].v[0]]));
      check(a, pa, a, pb, tally);
    }
  }
  CHECK(tally.unusual <= tally.pairs / 100);
}
