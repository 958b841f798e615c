// Exact tests of intersecting triangles: signs by filtered doubles, then by integers.
#include "triangles/predicates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tolerances.h"
#include "triangles/exact_triangles.h"

namespace tandem {
namespace predicates {
namespace {

// ---- Filter ----

int certain_sign(double x, double bound) { return x > bound ? 1 : x < -bound ? -1 : 0; }

// A difference of points, and a bound on each coordinate's error beyond its own rounding.
struct Difference {
  Vec3 v;
  double off;
};

// A cross product of differences, its error, and the sum of the absolute products.
struct Area {
  Vec3 n, size;
  double off;

  Area(const Difference& u, const Difference& v)
      : n(u.v.cross(v.v)), off(1.01 * (u.off * v.v.lpNorm<1>() + v.off * (u.v.lpNorm<1>() + 3 * u.off))) {
    const Vec3 x = u.v.cwiseAbs(), y = v.v.cwiseAbs();
    size = {x[1] * y[2] + x[2] * y[1], x[2] * y[0] + x[0] * y[2], x[0] * y[1] + x[1] * y[0]};
  }
  double error(Eigen::Index k) const {
    return tolerance::permanent_rounding * size[k] + off + std::numeric_limits<double>::min();
  }
  int sign(Eigen::Index k) const { return certain_sign(n[k], error(k)); }
  /// The sign of the product with w.
  int sign(const Difference& w) const {
    const double reach = w.v.lpNorm<1>() + 3 * w.off;
    return certain_sign(n.dot(w.v), tolerance::permanent_rounding * size.dot(w.v.cwiseAbs()) +
                                        1.01 * (w.off * size.sum() + off * reach) + std::numeric_limits<double>::min());
  }
};

// Two triangles with the signs of their determinants: from doubles where these are certain, else from integers. Corners
// 0 to 2 are A's, 3 to 5 B's.
class PairSigns {
 public:
  PairSigns(TriangleTest& test, const Corners& a, const Corners& b, const Corners& c)
      : test_(test), a_(a), b_(b), c_(c), area_{normal(0), normal(1)} {}

  bool meet() {
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        if ((c_[j] - a_[i]).cwiseAbs().maxCoeff() <= test_.delta() && same(i, j)) return true;
    if (apart()) return false;
    if (!has_area(0) || !has_area(1)) return exactly([](auto& x) { return x.meet(); }) != 0;
    Signs side[2];
    for (const std::size_t t : {1u, 0u}) {
      for (std::size_t k = 0; k < 3; ++k) side[1 - t][k] = plane_side(t, k);
      if (all_on_one_side(side[1 - t])) return false;
      if (side[1 - t] == Signs{0, 0, 0}) return coplanar_meet();
    }
    for (const std::size_t t : {0u, 1u})
      for (std::size_t k = 0; k < 3; ++k) {
        const int s = side[t][k], e = side[t][next_corner(k)];
        if (s * e > 0) continue;
        if (s == 0 && e == 0) {
          if (!beside(1 - t, t, k)) return true;
          continue;
        }
        if (no_two_sides(t == 0 ? Signs{edges(k, 0), edges(k, 1), edges(k, 2)}
                                : Signs{edges(0, k), edges(1, k), edges(2, k)}))
          return true;
      }
    return false;
  }

 private:
  template <class Ask>
  int exactly(Ask&& ask) {
    if (!exact_) exact_.emplace(test_.places()(a_, b_));
    return std::visit([&](auto& pair) -> int { return ask(pair); }, *exact_);
  }

  Difference difference(std::size_t i, std::size_t j) const {  // from corner i to corner j
    if (i < 3 && j < 3) return {a_[j] - a_[i], 0};
    if (i >= 3 && j >= 3) {
      // Not the difference of the transformed corners: their errors would be proportional to B's distance, not to its
      // size.
      const Vec3 d = b_[j - 3] - b_[i - 3];
      return {test_.map() * d, 64 * epsilon * d.lpNorm<1>()};
    }
    return i < 3 ? Difference{c_[j - 3] - a_[i], test_.delta()} : Difference{a_[j] - c_[i - 3], test_.delta()};
  }
  Area normal(std::size_t t) const { return Area(difference(3 * t, 3 * t + 1), difference(3 * t, 3 * t + 2)); }

  // True if an edge's normal in its triangle's plane separates them. That does not require certainty of being coplanar.
  bool apart() const {
    const double span = (c_[0] - a_[0]).lpNorm<1>() + area_extent();
    for (std::size_t t = 0; t < 2; ++t)
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 e = difference(3 * t + k, 3 * t + next_corner(k)).v;
        const Vec3 d = e.cross(area_[t].n);
        const double bound = d.lpNorm<1>() * (2 * test_.delta() + tolerance::permanent_rounding * span);
        double low_a = 0, high_a = 0, low_b = std::numeric_limits<double>::infinity(), high_b = -low_b;
        for (std::size_t i = 0; i < 3; ++i) {
          const double x = d.dot(a_[i] - a_[0]), y = d.dot(c_[i] - a_[0]);
          low_a = std::min(low_a, x), high_a = std::max(high_a, x);
          low_b = std::min(low_b, y), high_b = std::max(high_b, y);
        }
        if (low_a - high_b > bound || low_b - high_a > bound) return true;
      }
    return false;
  }
  double area_extent() const {
    double most = 0;
    for (std::size_t i = 1; i < 3; ++i)
      most = std::max({most, (a_[i] - a_[0]).lpNorm<1>(), (c_[i] - c_[0]).lpNorm<1>()});
    return most;
  }

  bool same(std::size_t i, std::size_t j) {
    if (test_.delta() == 0) return true;  // both in one frame: the positions are exact
    return exactly([&](auto& x) { return axis_of(x.a.p[i] - x.b.p[j]) == no_axis; }) != 0;
  }
  bool has_area(std::size_t t) {
    for (Eigen::Index k = 0; k < 3; ++k)
      if (area_[t].sign(k) != 0) return true;
    return exactly([&](auto& x) { return (t == 0 ? x.a : x.b).drop() != no_axis; }) != 0;
  }
  // The side of triangle t's plane on which corner k of the other lies.
  int plane_side(std::size_t t, std::size_t k) {
    if (const int s = area_[t].sign(difference(3 * t, 3 * (1 - t) + k))) return s;
    return exactly([&](auto& x) { return t == 0 ? x.a.side(x.b.p[k]) : x.b.side(x.a.p[k]); });
  }
  // The orientation of the line of A's edge i relative to that of B's edge j.
  int edges(std::size_t i, std::size_t j) {
    const Difference e = difference(i, next_corner(i)), f = difference(3 + j, 3 + next_corner(j));
    if (const int s = Area(f, e).sign(difference(i, 3 + j))) return s;
    return exactly([&](auto& x) {
      const auto &p = x.a.p[i], &q = x.b.p[j];
      return dot_sign(cross(x.b.p[next_corner(j)] - q, x.a.p[next_corner(i)] - p), q - p);
    });
  }
  // For corners in the plane of triangle t: the side of the line from i to j on which k lies.
  int turn(std::size_t t, std::size_t i, std::size_t j, std::size_t k) {
    Eigen::Index axis;
    area_[t].n.cwiseAbs().maxCoeff(&axis);
    if (const int s = area_[t].sign(axis) * Area(difference(i, j), difference(i, k)).sign(axis)) return s;
    return exactly([&](auto& x) {
      const auto point = [&](std::size_t c) -> const auto& { return c < 3 ? x.a.p[c] : x.b.p[c - 3]; };
      return (t == 0 ? x.a : x.b).turn(point(i), point(j), point(k));
    });
  }
  // True if edge k of triangle s, which lies in the plane of t, does not intersect t.
  bool beside(std::size_t t, std::size_t s, std::size_t k) {
    const std::size_t q = 3 * s + k, r = 3 * s + next_corner(k);
    for (std::size_t m = 0; m < 3; ++m) {
      const std::size_t p = 3 * t + m, n = 3 * t + next_corner(m);
      if (turn(t, p, n, q) < 0 && turn(t, p, n, r) < 0) return true;
    }
    return all_on_one_side({turn(t, q, r, 3 * t), turn(t, q, r, 3 * t + 1), turn(t, q, r, 3 * t + 2)});
  }
  bool coplanar_meet() {
    for (std::size_t t = 0; t < 2; ++t)
      for (std::size_t m = 0; m < 3; ++m) {
        const std::size_t p = 3 * t + m, n = 3 * t + next_corner(m), other = 3 * (1 - t);
        if (turn(t, p, n, other) < 0 && turn(t, p, n, other + 1) < 0 && turn(t, p, n, other + 2) < 0) return false;
      }
    return true;
  }

  TriangleTest& test_;
  const Corners &a_, &b_, &c_;
  const std::array<Area, 2> area_;
  std::optional<AnyExactPair> exact_;
};

double det(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (a - d).dot((b - d).cross(c - d)); }

// Rotates the corner that is alone on its side to the front.
Corners alone_first(const Corners& t, const Signs& s) {
  const std::size_t k = s[1] == s[2] ? 0 : s[0] == s[2] ? 1 : 2;
  return {t[k], t[next_corner(k)], t[next_corner(next_corner(k))]};
}

}  // namespace
}  // namespace predicates

TriangleTest::TriangleTest(const Pose& pose_a, const Pose& pose_b, double reach_b) {
  if (pose_a.rotation == pose_b.rotation && pose_a.translation == pose_b.translation) {
    // Both have the same pose: the triangles intersect in their frame if and only if they do in the world.
    map_ = Mat3::Identity();
    shift_ = Vec3::Zero();
    delta_ = 0;
    return;
  }
  pose_a_ = pose_a;
  pose_b_ = pose_b;
  // The true inverse, since a rotation may be off from orthonormal by 1e-6. Signs of volumes are those of the world, as
  // its determinant is positive.
  const Mat3 inverse = pose_a.rotation.inverse();
  const Vec3 between = pose_b.translation - pose_a.translation;
  map_ = inverse * pose_b.rotation;
  shift_ = inverse * between;
  delta_ = 64 * epsilon * (3 * reach_b + between.lpNorm<1>());
}

TriangleTest::~TriangleTest() = default;

const ExactPlaces& TriangleTest::places() {
  if (!places_) places_ = std::make_unique<ExactPlaces>(pose_a_, pose_b_);
  return *places_;
}

bool TriangleTest::exact(const predicates::Corners& a, const predicates::Corners& b) {
  return std::visit([](auto pair) { return pair.meet(); }, places()(a, b));
}

// Guigue and Devillers, Fast and robust triangle-triangle overlap test using orientation predicates, 2003.
bool TriangleTest::operator()(const predicates::Corners& a, const predicates::Corners& b,
                              const predicates::Corners& b_in_a) {
  const predicates::Corners& c = b_in_a;
  const Vec3 low_a = a[0].cwiseMin(a[1]).cwiseMin(a[2]), high_a = a[0].cwiseMax(a[1]).cwiseMax(a[2]);
  const Vec3 low_c = c[0].cwiseMin(c[1]).cwiseMin(c[2]), high_c = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
  if ((low_a - high_c).cwiseMax(low_c - high_a).maxCoeff() > delta_) return false;
  const Vec3 low = low_a.cwiseMin(low_c), high = high_a.cwiseMax(high_c);
  const double span = (high - low).maxCoeff();
  const double bound =
      span * span * (of_places() + tolerance::determinant_rounding * span) + std::numeric_limits<double>::min();

  const auto slowly = [&] { return predicates::PairSigns(*this, a, b, c).meet(); };
  const Vec3 normal_b = (c[1] - c[0]).cross(c[2] - c[0]);
  predicates::Signs side_a, side_b;
  for (std::size_t k = 0; k < 3; ++k) side_a[k] = predicates::certain_sign(normal_b.dot(a[k] - c[0]), bound);
  if (predicates::all_on_one_side(side_a)) return false;
  const Vec3 normal_a = (a[1] - a[0]).cross(a[2] - a[0]);
  for (std::size_t k = 0; k < 3; ++k) side_b[k] = predicates::certain_sign(normal_a.dot(c[k] - a[0]), bound);
  if (predicates::all_on_one_side(side_b)) return false;
  if (side_a[0] * side_a[1] * side_a[2] == 0 || side_b[0] * side_b[1] * side_b[2] == 0) return slowly();

  predicates::Corners p = predicates::alone_first(a, side_a), q = predicates::alone_first(c, side_b);
  // Makes each corner that is alone lie on the positive side of the other's plane.
  if (side_a[0] * side_a[1] * side_a[2] < 0) std::swap(q[1], q[2]);
  if (side_b[0] * side_b[1] * side_b[2] < 0) std::swap(p[1], p[2]);
  const int first = predicates::certain_sign(predicates::det(p[0], p[1], q[0], q[1]), bound);
  if (first < 0) return false;
  const int second = predicates::certain_sign(predicates::det(p[0], p[2], q[2], q[0]), bound);
  if (second < 0) return false;
  if (first == 0 || second == 0) return slowly();
  return true;
}

}  // namespace tandem
