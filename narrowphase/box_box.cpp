#include <limits>

#include "closed_forms.h"
#include "gjk.h"

namespace tandem {
namespace {

struct Boxes {
  Vec3 a, b;  // half sizes
  Mat3 r;
  Mat3 q;  // |r|
  Vec3 t;

  Boxes(const ConvexView& va, const ConvexView& vb, const RelativePose& pose)
      : a(va.param[0], va.param[1], va.param[2]),
        b(vb.param[0], vb.param[1], vb.param[2]),
        r(pose.rotation),
        q(pose.rotation.cwiseAbs()),
        t(pose.translation) {}

  /// How far apart along any unit n; true for every n, to rounding.
  double along(const Vec3& n) const {
    return std::abs(n.dot(t)) - a.dot(n.cwiseAbs()) - b.dot((r.transpose() * n).cwiseAbs());
  }
};

// Shorter cross products come from edges so nearly parallel that their sliver of a facet matters less than rounding.
constexpr double parallel2 = 1e-20;
// Below this the short formulas lose digits: the axis is projected in full.
constexpr double slow2 = 1e-6;

// An edge or face within this angle of the other's face lies in it.
constexpr double flat = 1e-11;
// Points closer than this to where they should be, squared and relative.
constexpr double rounding2 = 1e-24;

/// Separation along the edge axis a_i x b_j, times its length.
inline double edge_numerator(const Boxes& x, int i, int j) {
  const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
  const double centre = std::abs(x.t[i2] * x.r(i1, j) - x.t[i1] * x.r(i2, j));
  return centre - (x.a[i1] * x.q(i2, j) + x.a[i2] * x.q(i1, j)) - (x.b[j1] * x.q(i, j2) + x.b[j2] * x.q(i, j1));
}

inline Vec3 edge_axis(const Boxes& x, int i, int j) { return Vec3::Unit(i).cross(x.r.col(j)); }

inline double edge_length2(const Boxes& x, int i, int j) {
  const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
  return x.r(i1, j) * x.r(i1, j) + x.r(i2, j) * x.r(i2, j);
}

/// A point of a box (half sizes b, at r, t) that lies over the face n = +-e_axis of the box with half sizes a at the
/// origin, among the points of b deepest against n: a corner, or one of an edge or a face where they lie flat.
/// False where rounding finds none.
bool over_face(const Vec3& a, int axis, const Vec3& n, const Vec3& b, const Mat3& r, const Vec3& t, Vec3& point) {
  const Vec3 m = r.transpose() * n;
  Vec3 corner;
  int free[3], frees = 0;
  for (int k = 0; k < 3; ++k) {
    corner[k] = -std::copysign(b[k], m[k]);
    if (std::abs(m[k]) <= flat) free[frees++] = k;
  }
  const int u = (axis + 1) % 3, w = (axis + 2) % 3;
  const double slack = 1e-12 * (a.sum() + b.sum());
  point = t + r * corner;
  if (std::abs(point[u]) <= a[u] && std::abs(point[w]) <= a[w]) return true;
  if (frees == 0) return std::abs(point[u]) <= a[u] + slack && std::abs(point[w]) <= a[w] + slack;
  for (int i = 0; i < frees * frees; ++i) {  // the edge, or the face's four
    const int k = free[i % frees], other = free[frees - 1 - i % frees];
    Vec3 middle = corner;
    if (i >= frees) middle[other] = -middle[other];
    middle[k] = 0;
    const Vec3 from = t + r * middle, along = b[k] * r.col(k);
    double lo = -1, hi = 1;
    for (const int e : {u, w}) {
      if (std::abs(along[e]) > slack) {
        const double s = (-a[e] - from[e]) / along[e], q = (a[e] - from[e]) / along[e];
        lo = std::max(lo, std::min(s, q));
        hi = std::min(hi, std::max(s, q));
      } else if (std::abs(from[e]) > a[e]) {
        hi = -2;
      }
    }
    if (lo <= hi) {
      point = from + 0.5 * (lo + hi) * along;
      return true;
    }
  }
  if (frees == 1) return false;
  // No edge of b's face crosses a's: one lies within the other, or they miss by rounding.
  const double height = point[axis];
  point.setZero();
  point[axis] = height;
  return ((r.transpose() * (point - t)).cwiseAbs().array() <= b.array() + slack).all();
}

}  // namespace

bool box_box_collide(const ConvexView& va, const ConvexView& vb, const RelativePose& pose) {
  const Boxes x(va, vb, pose);
  for (int i = 0; i < 3; ++i)
    if (std::abs(x.t[i]) - x.a[i] - x.q.row(i).dot(x.b) > 0) return false;
  for (int j = 0; j < 3; ++j)
    if (std::abs(x.r.col(j).dot(x.t)) - x.b[j] - x.q.col(j).dot(x.a) > 0) return false;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double length2 = edge_length2(x, i, j);
      if (length2 > slow2) {
        if (edge_numerator(x, i, j) > 0) return false;
      } else if (length2 > parallel2) {
        if (x.along(edge_axis(x, i, j) / std::sqrt(length2)) > 0) return false;
      }
    }
  return true;
}

LocalAnswer box_box_separation(const ConvexView& va, const ConvexView& vb, const RelativePose& pose) {
  const Boxes x(va, vb, pose);
  double best = -std::numeric_limits<double>::infinity();
  int axis = 0;
  for (int i = 0; i < 3; ++i) {
    const double s = std::abs(x.t[i]) - x.a[i] - x.q.row(i).dot(x.b);
    if (s > best) best = s, axis = i;
  }
  const Vec3 t_in_b = x.r.transpose() * x.t;
  for (int j = 0; j < 3; ++j) {
    const double s = std::abs(t_in_b[j]) - x.b[j] - x.q.col(j).dot(x.a);
    if (s > best) best = s, axis = 3 + j;
  }
  // An edge axis that is a face's too must not win by its rounding: the face's formula is the more exact one.
  const double least = 1e-15 * (x.a.sum() + x.b.sum());
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double length2 = edge_length2(x, i, j);
      if (!(length2 > parallel2)) continue;
      const double length = std::sqrt(length2);
      const double s = length2 > slow2 ? edge_numerator(x, i, j) / length : x.along(edge_axis(x, i, j) / length);
      if (s > best + (axis < 6 ? least : 0.0)) best = s, axis = 6 + 3 * i + j;
    }
  LocalAnswer answer;
  answer.signed_distance = best;
  if (axis < 3) {
    answer.normal = Vec3::Unit(axis);
  } else if (axis < 6) {
    answer.normal = x.r.col(axis - 3);
  } else {
    answer.normal = edge_axis(x, (axis - 6) / 3, (axis - 6) % 3).normalized();
  }
  if (answer.normal.dot(x.t) < 0) answer.normal = -answer.normal;

  // Witness points: the deepest corner of the shape whose face it is not, or the two edges' nearest points.
  const Vec3& n = answer.normal;
  bool paired = true;
  if (axis < 3) {
    paired = over_face(x.a, axis, n, x.b, x.r, x.t, answer.point_b);
    answer.point_a = answer.point_b - best * n;
  } else if (axis < 6) {
    const Mat3 back = x.r.transpose();
    Vec3 in_b;
    paired = over_face(x.b, axis - 3, -(back * n), x.a, back, -(back * x.t), in_b);
    answer.point_a = x.t + x.r * in_b;
    answer.point_b = answer.point_a + best * n;
  } else {
    const int i = (axis - 6) / 3, j = (axis - 6) % 3;
    Vec3 ca = core_support(va, n), cb = core_support(vb, -(x.r.transpose() * n));
    ca[i] = 0;
    cb[j] = 0;
    const SegmentDistance d = segment_distance(ca, x.a[i] * Vec3::Unit(i), x.t + x.r * cb, x.b[j] * x.r.col(j));
    answer.point_a = d.point_a;
    answer.point_b = d.point_a + best * n;
    paired = (d.point_b - answer.point_b).squaredNorm() <= rounding2 * (x.a + x.b).squaredNorm();
  }
  // Parallel faces and edges: many corners are equally deep, and not all of them lie over the other box.
  if (best <= 0 && !paired) pair_points({va, vb, pose}, answer);
  return answer;
}

}  // namespace tandem
