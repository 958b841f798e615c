#include "predicates.h"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>

#include "exact_number.h"

namespace tandem {
namespace {

using Corners = std::array<Vec3, 3>;

// ---- Exact: the definition, for any number type with exact + - * and sign ----

using Rational = boost::multiprecision::cpp_rational;

int sign(const Expansion& x) { return x.sign(); }
int sign(const Rational& x) { return x.sign(); }

template <class Number>
Number times(double x, double y);
template <>
Expansion times<Expansion>(double x, double y) {
  return Expansion::product(x, y);
}
template <>
Rational times<Rational>(double x, double y) {
  return Rational(x) * Rational(y);
}

template <class Number>
using Point = std::array<Number, 3>;

constexpr std::size_t no_axis = 3;

template <class N>
Point<N> operator-(const Point<N>& p, const Point<N>& q) {
  return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}

template <class N>
Point<N> cross(const Point<N>& u, const Point<N>& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

template <class N>
N dot(const Point<N>& u, const Point<N>& v) {
  return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

template <class N>
std::size_t axis_of(const Point<N>& n) {  // the first axis along which n is not zero, or no_axis
  for (std::size_t k = 0; k < 3; ++k)
    if (sign(n[k]) != 0) return k;
  return no_axis;
}

template <class N>
int orient(const Point<N>& a, const Point<N>& b, const Point<N>& c, const Point<N>& d) {
  return sign(dot(a - d, cross(b - d, c - d)));
}

// The same points without coordinate `drop`.
template <class N>
int orient2(const Point<N>& a, const Point<N>& b, const Point<N>& c, std::size_t drop) {
  const std::size_t i = (drop + 1) % 3, j = (drop + 2) % 3;
  return sign((b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]));
}

template <class N>
bool intervals_meet(const N& p, const N& q, const N& r, const N& s) {
  const bool pq = sign(q - p) >= 0, rs = sign(s - r) >= 0;
  return sign((rs ? s : r) - (pq ? p : q)) >= 0 && sign((pq ? q : p) - (rs ? r : s)) >= 0;
}

// Closed segments in a plane that projects one to one along `drop`. Either may be a point.
template <class N>
bool segments_meet2(const Point<N>& p, const Point<N>& q, const Point<N>& r, const Point<N>& s, std::size_t drop) {
  const int o1 = orient2(p, q, r, drop), o2 = orient2(p, q, s, drop);
  if (o1 * o2 > 0) return false;
  const int o3 = orient2(r, s, p, drop), o4 = orient2(r, s, q, drop);
  if (o3 * o4 > 0) return false;
  if (o1 != 0 || o2 != 0 || o3 != 0 || o4 != 0) return true;
  const std::size_t i = (drop + 1) % 3, j = (drop + 2) % 3;
  return intervals_meet(p[i], q[i], r[i], s[i]) && intervals_meet(p[j], q[j], r[j], s[j]);
}

template <class N>
bool segments_meet(const Point<N>& p, const Point<N>& q, const Point<N>& r, const Point<N>& s) {
  const Point<N> pq = q - p, pr = r - p, ps = s - p, qr = r - q, qs = s - q;
  for (const Point<N>& n : {cross(pq, pr), cross(pq, ps), cross(pr, ps), cross(qr, qs)})
    if (const std::size_t drop = axis_of(n); drop != no_axis)
      return orient(p, q, r, s) == 0 && segments_meet2(p, q, r, s, drop);
  // All on one line, or one point.
  for (std::size_t k = 0; k < 3; ++k)
    if (!intervals_meet(p[k], q[k], r[k], s[k])) return false;
  return true;
}

template <class N>
struct ExactTriangle {
  std::array<Point<N>, 3> p;
  Point<N> normal;
  std::size_t drop;  // no_axis: no area

  explicit ExactTriangle(const std::array<Point<N>, 3>& corners)
      : p(corners), normal(cross(p[1] - p[0], p[2] - p[0])), drop(axis_of(normal)) {}

  std::array<int, 3> sides(const ExactTriangle& other) const {
    std::array<int, 3> s{};
    if (drop != no_axis)
      for (std::size_t k = 0; k < 3; ++k) s[k] = sign(dot(normal, other.p[k] - p[0]));
    return s;
  }
  bool holds_coplanar(const Point<N>& q) const {
    int low = 0, high = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const int o = orient2(p[k], p[(k + 1) % 3], q, drop);
      low = std::min(low, o);
      high = std::max(high, o);
    }
    return low == 0 || high == 0;
  }
  bool meets_coplanar(const Point<N>& q, const Point<N>& r) const {
    if (holds_coplanar(q) || holds_coplanar(r)) return true;
    for (std::size_t k = 0; k < 3; ++k)
      if (segments_meet2(q, r, p[k], p[(k + 1) % 3], drop)) return true;
    return false;
  }
  // Segment q r, whose ends lie on sides sq and sr of the plane.
  bool meets(const Point<N>& q, const Point<N>& r, int sq, int sr) const {
    if (drop == no_axis) {
      for (std::size_t k = 0; k < 3; ++k)
        if (segments_meet(q, r, p[k], p[(k + 1) % 3])) return true;
      return false;
    }
    if (sq * sr > 0) return false;
    if (sq == 0 && sr == 0) return meets_coplanar(q, r);
    int low = 0, high = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const int o = orient(q, r, p[k], p[(k + 1) % 3]);
      low = std::min(low, o);
      high = std::max(high, o);
    }
    return low == 0 || high == 0;
  }
};

bool one_side(const std::array<int, 3>& s) { return s[0] != 0 && s[0] == s[1] && s[1] == s[2]; }

// Two closed triangles meet if and only if an edge of one meets the other: an extreme point of what they share lies on
// the border of one of them.
template <class N>
bool exact_meet(const ExactTriangle<N>& a, const ExactTriangle<N>& b) {
  const auto side_a = b.sides(a);
  if (one_side(side_a)) return false;
  const auto side_b = a.sides(b);
  if (one_side(side_b)) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t n = (k + 1) % 3;
    if (b.meets(a.p[k], a.p[n], side_a[k], side_a[n])) return true;
    if (a.meets(b.p[k], b.p[n], side_b[k], side_b[n])) return true;
  }
  return false;
}

template <class N>
ExactTriangle<N> place(const Corners& corners, const Pose& pose) {
  std::array<Point<N>, 3> world;
  for (std::size_t c = 0; c < 3; ++c)
    for (int i = 0; i < 3; ++i) {
      N x(pose.translation[i]);
      for (int j = 0; j < 3; ++j) x = x + times<N>(pose.rotation(i, j), corners[c][j]);
      world[c][static_cast<std::size_t>(i)] = x;
    }
  return ExactTriangle<N>(world);
}

bool in_range(double x) {
  const double size = std::abs(x);
  return size == 0 || (size >= 0x1p-120 && size <= 0x1p120);
}

bool in_range(const Pose& pose) {
  return std::all_of(pose.rotation.data(), pose.rotation.data() + 9, [](double x) { return in_range(x); }) &&
         std::all_of(pose.translation.data(), pose.translation.data() + 3, [](double x) { return in_range(x); });
}

bool in_range(const Corners& c) {
  return std::all_of(c.begin(), c.end(),
                     [](const Vec3& v) { return in_range(v.x()) && in_range(v.y()) && in_range(v.z()); });
}

// ---- Filter ----

int certain_sign(double x, double bound) { return x > bound ? 1 : x < -bound ? -1 : 0; }

double det(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (a - d).dot((b - d).cross(c - d)); }

// Brings the corner that is alone on its side to the front, keeping the sense.
Corners alone_first(const Corners& t, const std::array<int, 3>& s) {
  const std::size_t k = s[1] == s[2] ? 0 : s[0] == s[2] ? 1 : 2;
  return {t[k], t[(k + 1) % 3], t[(k + 2) % 3]};
}

}  // namespace

TriangleTest::TriangleTest(const Pose& pose_a, const Pose& pose_b, double reach_b) : pose_a_(pose_a), pose_b_(pose_b) {
  // The true inverse: a rotation may be off from orthonormal by 1e-6. Signs of volumes are those of the world, as its
  // determinant is positive.
  const Mat3 inverse = pose_a.rotation.inverse();
  const Vec3 between = pose_b.translation - pose_a.translation;
  map_ = inverse * pose_b.rotation;
  shift_ = inverse * between;
  delta_ = 64 * std::numeric_limits<double>::epsilon() * (3 * reach_b + between.lpNorm<1>());
}

bool TriangleTest::exact(const Corners& a, const Corners& b) const {
  if (in_range(pose_a_) && in_range(pose_b_) && in_range(a) && in_range(b))
    return exact_meet(place<Expansion>(a, pose_a_), place<Expansion>(b, pose_b_));
  return exact_meet(place<Rational>(a, pose_a_), place<Rational>(b, pose_b_));
}

// Guigue and Devillers, Fast and robust triangle-triangle overlap test using orientation predicates, 2003.
bool TriangleTest::operator()(const Corners& a, const Corners& b, const Corners& b_in_a) const {
  const Corners& c = b_in_a;
  const Vec3 low_a = a[0].cwiseMin(a[1]).cwiseMin(a[2]), high_a = a[0].cwiseMax(a[1]).cwiseMax(a[2]);
  const Vec3 low_c = c[0].cwiseMin(c[1]).cwiseMin(c[2]), high_c = c[0].cwiseMax(c[1]).cwiseMax(c[2]);
  if ((low_a - high_c).cwiseMax(low_c - high_a).maxCoeff() > delta_) return false;
  const Vec3 low = low_a.cwiseMin(low_c), high = high_a.cwiseMax(high_c);
  // Every difference is at most `span`, and wrong by 2 delta plus its rounding. A determinant of them is then wrong by
  // less than 6 span^2 (6 delta + 10 u span), u = 2^-53.
  const double span = (high - low).maxCoeff();
  const double bound = span * span * (48 * delta_ + 1e-14 * span) + std::numeric_limits<double>::min();

  const Vec3 normal_b = (c[1] - c[0]).cross(c[2] - c[0]);
  std::array<int, 3> side_a, side_b;
  for (std::size_t k = 0; k < 3; ++k) side_a[k] = certain_sign(normal_b.dot(a[k] - c[0]), bound);
  if (one_side(side_a)) return false;
  const Vec3 normal_a = (a[1] - a[0]).cross(a[2] - a[0]);
  for (std::size_t k = 0; k < 3; ++k) side_b[k] = certain_sign(normal_a.dot(c[k] - a[0]), bound);
  if (one_side(side_b)) return false;
  if (side_a[0] * side_a[1] * side_a[2] == 0 || side_b[0] * side_b[1] * side_b[2] == 0) return exact(a, b);

  Corners p = alone_first(a, side_a), q = alone_first(c, side_b);
  // Each alone corner on the positive side of the other's plane.
  if (side_a[0] * side_a[1] * side_a[2] < 0) std::swap(q[1], q[2]);
  if (side_b[0] * side_b[1] * side_b[2] < 0) std::swap(p[1], p[2]);
  const int first = certain_sign(det(p[0], p[1], q[0], q[1]), bound);
  if (first < 0) return false;
  const int second = certain_sign(det(p[0], p[2], q[2], q[0]), bound);
  if (second < 0) return false;
  if (first == 0 || second == 0) return exact(a, b);
  return true;
}

}  // namespace tandem
