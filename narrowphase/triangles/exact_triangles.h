// Intersecting triangles by the definition, for any type of integer whose sums and products are exact.
#pragma once
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <variant>

#include "tandem/narrowphase/pose.h"
#include "triangles/exact_number.h"

namespace tandem {
namespace predicates {

using Corners = std::array<Vec3, 3>;
using Signs = std::array<int, 3>;

constexpr std::size_t next_corner(std::size_t k) { return k == 2 ? 0 : k + 1; }
inline bool all_on_one_side(const Signs& s) { return s[0] != 0 && s[0] == s[1] && s[1] == s[2]; }
// True if no two signs oppose: a line that passes all edges of a triangle on one side, or touches, crosses it.
inline bool no_two_sides(const Signs& s) {
  return (s[0] >= 0 && s[1] >= 0 && s[2] >= 0) || (s[0] <= 0 && s[1] <= 0 && s[2] <= 0);
}

template <class N>
using Point = std::array<N, 3>;

constexpr std::size_t no_axis = 3;

template <class N>
Point<N> operator-(const Point<N>& p, const Point<N>& q) {
  return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}

template <class N>
auto minor(const Point<N>& u, const Point<N>& v, std::size_t k) {
  const std::size_t i = next_corner(k), j = next_corner(i);
  return u[i] * v[j] - u[j] * v[i];
}

template <class N>
auto cross(const Point<N>& u, const Point<N>& v) {
  return Point<decltype(u[0] * v[0])>{minor(u, v, 0), minor(u, v, 1), minor(u, v, 2)};
}

template <class M, class N>
int dot_sign(const Point<M>& u, const Point<N>& v) {
  return (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]).sign();
}

template <class N>
std::size_t axis_of(const Point<N>& n) {  // the first axis along which n is not zero, or no_axis
  for (std::size_t k = 0; k < 3; ++k)
    if (n[k].sign() != 0) return k;
  return no_axis;
}

template <class N>
int orient(const Point<N>& a, const Point<N>& b, const Point<N>& c, const Point<N>& d) {
  return dot_sign(cross(b - d, c - d), a - d);
}

// The orientation of three points projected onto the plane without coordinate `drop`.
template <class N>
int orient2(const Point<N>& a, const Point<N>& b, const Point<N>& c, std::size_t drop) {
  return minor(b - a, c - a, drop).sign();
}

template <class N>
bool intervals_meet(const N& p, const N& q, const N& r, const N& s) {
  const bool pq = (q - p).sign() >= 0, rs = (s - r).sign() >= 0;
  return ((rs ? s : r) - (pq ? p : q)).sign() >= 0 && ((pq ? q : p) - (rs ? r : s)).sign() >= 0;
}

// True if closed segments intersect, in a plane that projects one to one along `drop`. Either may be a point.
template <class N>
bool segments_meet2(const Point<N>& p, const Point<N>& q, const Point<N>& r, const Point<N>& s, std::size_t drop) {
  const int o1 = orient2(p, q, r, drop), o2 = orient2(p, q, s, drop);
  if (o1 * o2 > 0) return false;
  const int o3 = orient2(r, s, p, drop), o4 = orient2(r, s, q, drop);
  if (o3 * o4 > 0) return false;
  if (o1 != 0 || o2 != 0 || o3 != 0 || o4 != 0) return true;
  const std::size_t i = next_corner(drop), j = next_corner(i);
  return intervals_meet(p[i], q[i], r[i], s[i]) && intervals_meet(p[j], q[j], r[j], s[j]);
}

template <class N>
bool segments_meet(const Point<N>& p, const Point<N>& q, const Point<N>& r, const Point<N>& s) {
  const Point<N> pq = q - p, pr = r - p, ps = s - p, qr = r - q, qs = s - q;
  for (const auto& n : {cross(pq, pr), cross(pq, ps), cross(pr, ps), cross(qr, qs)})
    if (const std::size_t drop = axis_of(n); drop != no_axis)
      return orient(p, q, r, s) == 0 && segments_meet2(p, q, r, s, drop);
  // All on one line, or one point.
  for (std::size_t k = 0; k < 3; ++k)
    if (!intervals_meet(p[k], q[k], r[k], s[k])) return false;
  return true;
}

template <class N>
class ExactTriangle {
 public:
  std::array<Point<N>, 3> p;

  std::size_t drop() {  // an axis along which the triangle's plane projects one to one; no_axis: no area
    if (!normal_) normal_ = cross(p[1] - p[0], p[2] - p[0]), drop_ = axis_of(*normal_);
    return drop_;
  }
  int side(const Point<N>& q) { return drop() == no_axis ? 0 : dot_sign(*normal_, q - p[0]); }
  Signs sides(const ExactTriangle& other) { return {side(other.p[0]), side(other.p[1]), side(other.p[2])}; }
  // In the triangle's plane: the side of the line from q to r on which s lies, as seen from where the corners are
  // counterclockwise.
  int turn(const Point<N>& q, const Point<N>& r, const Point<N>& s) {
    return orient2(q, r, s, drop()) * (*normal_)[drop()].sign();
  }
  // True if segment q r intersects; its ends lie on sides sq and sr of the plane.
  bool meets(const Point<N>& q, const Point<N>& r, int sq, int sr) {
    if (drop() == no_axis) {
      for (std::size_t k = 0; k < 3; ++k)
        if (segments_meet(q, r, p[k], p[next_corner(k)])) return true;
      return false;
    }
    if (sq * sr > 0) return false;
    if (sq == 0 && sr == 0) return meets_coplanar(q, r);
    return no_two_sides({orient(q, r, p[0], p[1]), orient(q, r, p[1], p[2]), orient(q, r, p[2], p[0])});
  }

 private:
  bool holds_coplanar(const Point<N>& q) const {
    return no_two_sides({orient2(p[0], p[1], q, drop_), orient2(p[1], p[2], q, drop_), orient2(p[2], p[0], q, drop_)});
  }
  bool meets_coplanar(const Point<N>& q, const Point<N>& r) const {
    if (holds_coplanar(q) || holds_coplanar(r)) return true;
    for (std::size_t k = 0; k < 3; ++k)
      if (segments_meet2(q, r, p[k], p[next_corner(k)], drop_)) return true;
    return false;
  }

  std::optional<Point<decltype(N() * N())>> normal_;
  std::size_t drop_ = no_axis;
};

template <class N>
struct ExactPair {
  ExactTriangle<N> a, b;

  // Two closed triangles intersect if and only if an edge of one intersects the other: an extreme point of the
  // intersection lies on the border of one of them.
  bool meet() {
    const Signs side_a = b.sides(a);
    if (all_on_one_side(side_a)) return false;
    const Signs side_b = a.sides(b);
    if (all_on_one_side(side_b)) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      if (b.meets(a.p[k], a.p[next_corner(k)], side_a[k], side_a[next_corner(k)])) return true;
      if (a.meets(b.p[k], b.p[next_corner(k)], side_b[k], side_b[next_corner(k)])) return true;
    }
    return false;
  }
};

struct DyadicPose {
  std::array<Dyadic, 9> rotation;  // row by row
  Point<Dyadic> translation;

  explicit DyadicPose(const Pose& pose) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) rotation[static_cast<std::size_t>(3 * i + j)] = Dyadic(pose.rotation(i, j));
      translation[static_cast<std::size_t>(i)] = Dyadic(pose.translation[i]);
    }
  }
};

using AnyExactPair =
    std::variant<ExactPair<WideInt<2>>, ExactPair<WideInt<4>>, ExactPair<WideInt<8>>, ExactPair<UnboundedInt>>;

}  // namespace predicates

/// Transforms points of two shapes, A and B, to the world in integers, in a unit that fits both.
class ExactPlaces {
 public:
  ExactPlaces(const Pose& pose_a, const Pose& pose_b)
      : pose_{predicates::DyadicPose(pose_a), predicates::DyadicPose(pose_b)} {}

  /// Calls `ask` with the places of A's points and of B's: arrays of points whose coordinates are integers in one unit.
  /// Differences fit the same type, and products have wider ones, so that all determinants of differences are exact.
  template <std::size_t CountA, std::size_t CountB, class Ask>
  auto visit(const std::array<Vec3, CountA>& points_a, const std::array<Vec3, CountB>& points_b, Ask&& ask) const {
    const auto a = dyadic(points_a);
    const auto b = dyadic(points_b);
    Range range;
    include(a, pose_[0], range);
    include(b, pose_[1], range);
    const auto asked = [&]<class N>(N) {
      std::array<predicates::Point<N>, CountA> placed_a;
      std::array<predicates::Point<N>, CountB> placed_b;
      place(a, pose_[0], range.low, placed_a);
      place(b, pose_[1], range.low, placed_b);
      return ask(placed_a, placed_b);
    };
    // A coordinate is a sum of four terms; a determinant of differences then leaves the top bits unused.
    const int bits = range.empty() ? 0 : range.high - range.low + 2;
    if (bits <= 2 * 64 - 4) return asked(WideInt<2>());
    if (bits <= 4 * 64 - 4) return asked(WideInt<4>());
    if (bits <= 8 * 64 - 4) return asked(WideInt<8>());
    return asked(UnboundedInt());
  }
  predicates::AnyExactPair operator()(const predicates::Corners& a, const predicates::Corners& b) const {
    return visit(a, b,
                 []<class N>(const std::array<predicates::Point<N>, 3>& p,
                             const std::array<predicates::Point<N>, 3>& q) -> predicates::AnyExactPair {
                   predicates::ExactPair<N> pair;
                   pair.a.p = p;
                   pair.b.p = q;
                   return pair;
                 });
  }

 private:
  struct Range {
    int low = std::numeric_limits<int>::max(), high = std::numeric_limits<int>::min();
    void add(const Dyadic& x) {
      if (x.mantissa) low = std::min(low, x.exponent), high = std::max(high, x.top());
    }
    bool empty() const { return high < low; }
  };

  template <std::size_t Count>
  static std::array<predicates::Point<Dyadic>, Count> dyadic(const std::array<Vec3, Count>& points) {
    std::array<predicates::Point<Dyadic>, Count> r;
    for (std::size_t c = 0; c < Count; ++c)
      for (std::size_t k = 0; k < 3; ++k) r[c][k] = Dyadic(points[c][static_cast<Eigen::Index>(k)]);
    return r;
  }
  /// Extends the range of exponents by the terms of the points' places.
  template <std::size_t Count>
  static void include(const std::array<predicates::Point<Dyadic>, Count>& points, const predicates::DyadicPose& pose,
                      Range& range) {
    for (const Dyadic& t : pose.translation) range.add(t);
    for (std::size_t j = 0; j < 3; ++j) {
      Range column, coordinate;
      for (std::size_t i = 0; i < 3; ++i) column.add(pose.rotation[3 * i + j]);
      for (const auto& p : points) coordinate.add(p[j]);
      if (column.empty() || coordinate.empty()) continue;
      range.low = std::min(range.low, column.low + coordinate.low);
      range.high = std::max(range.high, column.high + coordinate.high);
    }
  }
  template <class N, std::size_t Count>
  static void place(const std::array<predicates::Point<Dyadic>, Count>& points, const predicates::DyadicPose& pose,
                    int low, std::array<predicates::Point<N>, Count>& places) {
    for (std::size_t c = 0; c < Count; ++c)
      for (std::size_t i = 0; i < 3; ++i) {
        const Dyadic& t = pose.translation[i];
        N& x = places[c][i];
        if (t.mantissa) x.add(t.mantissa, static_cast<unsigned>(t.exponent - low), t.negative);
        for (std::size_t j = 0; j < 3; ++j) {
          const Dyadic &r = pose.rotation[3 * i + j], &v = points[c][j];
          if (r.mantissa && v.mantissa)
            x.add(Uint128{r.mantissa} * v.mantissa, static_cast<unsigned>(r.exponent + v.exponent - low),
                  r.negative != v.negative);
        }
      }
  }

  std::array<predicates::DyadicPose, 2> pose_;
};

}  // namespace tandem
