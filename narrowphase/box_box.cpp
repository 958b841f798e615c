#include <bit>
#include <limits>

#include "closed_forms.h"
#include "gjk.h"

namespace tandem {
namespace {

// Squared sine of the angle of two edges. Below the first they are as good as parallel and make no axis of their own;
// below the second the short formula loses digits, and more where the rotation is off from orthonormal: the axis is
// projected in full.
constexpr double parallel2 = 1e-30;
constexpr double slow2 = 1e-2;
constexpr double slow_cosine = 0.99498743710662;  // sqrt(1 - slow2)

// An edge or face within this angle of the other's face lies in it.
constexpr double flat = 1e-11;
// Points closer than this to where they should be, squared and relative.
constexpr double rounding2 = 1e-24;
// What the terms of an axis may lose together, relative to the boxes' size.
constexpr double rounding = 4e-15;

constexpr int next[3] = {1, 2, 0}, last[3] = {2, 0, 1};

/// Two boxes for the separating axis test: B as A sees it. Everything but the edges' axes comes out the same, bit for
/// bit, with A and B exchanged.
struct Boxes {
  double a[3], b[3];  ///< half sizes
  double r[3][3];     ///< columns: B's axes in A's frame
  double q[3][3];     ///< |r|
  double t[3];        ///< from A's centre to B's in A's frame
  double u[3];        ///< and in B's

  void place(const Vec3& half_a, const Pose& pose_a, const Vec3& half_b, const Pose& pose_b) {
    const Vec3 d = pose_b.translation - pose_a.translation;
    for (int i = 0; i < 3; ++i) {
      a[i] = half_a[i];
      b[i] = half_b[i];
      t[i] = pose_a.rotation.col(i).dot(d);
      u[i] = pose_b.rotation.col(i).dot(d);
      for (int j = 0; j < 3; ++j) r[i][j] = pose_a.rotation.col(i).dot(pose_b.rotation.col(j));
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) q[i][j] = std::abs(r[i][j]);
  }

  double size() const { return a[0] + a[1] + a[2] + b[0] + b[1] + b[2]; }

  double face_of_a(int i) const { return std::abs(t[i]) - a[i] - (q[i][0] * b[0] + q[i][1] * b[1] + q[i][2] * b[2]); }
  double face_of_b(int j) const { return std::abs(u[j]) - b[j] - (q[0][j] * a[0] + q[1][j] * a[1] + q[2][j] * a[2]); }
  /// Separation along the edge axis a_i x b_j, times that product's length; for orthonormal axes.
  double edge(int i, int j) const {
    const int i1 = next[i], i2 = last[i], j1 = next[j], j2 = last[j];
    const double centre = std::abs(t[i2] * r[i1][j] - t[i1] * r[i2][j]);
    return centre - (a[i1] * q[i2][j] + a[i2] * q[i1][j]) - (b[j1] * q[i][j2] + b[j2] * q[i][j1]);
  }
  /// Squared length of a_i x b_j.
  double edge_length2(int i, int j) const {
    const double x = r[next[i]][j], y = r[last[i]][j];
    return x * x + y * y;
  }
  Vec3 edge_axis(int i, int j, double length) const {
    Vec3 n = Vec3::Zero();
    n[next[i]] = -r[last[i]][j] / length;
    n[last[i]] = r[next[i]][j] / length;
    return n;
  }
  /// How far apart along any unit n; true for every n, to rounding: never more than the signed distance.
  double along(const Vec3& n) const {
    double s = std::abs(n[0] * t[0] + n[1] * t[1] + n[2] * t[2]);
    for (int k = 0; k < 3; ++k) s -= a[k] * std::abs(n[k]);
    for (int k = 0; k < 3; ++k) s -= b[k] * std::abs(n[0] * r[0][k] + n[1] * r[1][k] + n[2] * r[2][k]);
    return s;
  }
  double along_edge(int i, int j) const {
    const double length2 = edge_length2(i, j);
    return length2 > parallel2 ? along(edge_axis(i, j, std::sqrt(length2))) : -std::numeric_limits<double>::infinity();
  }

  Vec3 translation() const { return {t[0], t[1], t[2]}; }
  Mat3 rotation() const {
    Mat3 m;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) m(i, j) = r[i][j];
    return m;
  }
};

/// The edge axes decide, and at least one too closely for the short formula.
[[gnu::noinline]] bool edges_separate(const Boxes& x, double doubt) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if ((x.q[i][j] > slow_cosine || x.edge(i, j) > -doubt) && x.along_edge(i, j) > 0) return true;
  return false;
}

/// A point of a box (half sizes b, at r, t) that lies over the face n = +-e_axis of the box with half sizes a at the
/// origin, among the points of b deepest against n: a corner, or one of an edge or a face where they lie flat.
/// False where rounding finds none.
bool over_face(const Vec3& a, int axis, const Vec3& n, const Vec3& b, const Mat3& r, const Vec3& t, Vec3& point) {
  const Vec3 m = r.transpose() * n;
  Vec3 corner;
  int free[3] = {}, frees = 0;
  for (int k = 0; k < 3; ++k) {
    corner[k] = -std::copysign(b[k], m[k]);
    if (std::abs(m[k]) <= flat) free[frees++] = k;
  }
  const int u = next[axis], w = last[axis];
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

/// The axis that separates best, and by how much.
struct Separation {
  double distance;
  int axis;  ///< 0-2: A's faces, 3-5: B's, 6 + 3 i + j: a_i x b_j
};

Separation separation(const Boxes& x) {
  double face[6], numerator[9];
  for (int i = 0; i < 3; ++i) face[i] = x.face_of_a(i);
  for (int j = 0; j < 3; ++j) face[3 + j] = x.face_of_b(j);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) numerator[3 * i + j] = x.edge(i, j);
  Separation best{face[0], 0};
  for (int k = 1; k < 6; ++k) best = face[k] > best.distance ? Separation{face[k], k} : best;
  // The numerator is the separation times a length <= 1: one below this cannot win, and most are.
  const double hopeless = std::min(best.distance, 0.0);
  unsigned hopeful = 0;
  for (int k = 0; k < 9; ++k) hopeful |= (numerator[k] > hopeless || (&x.q[0][0])[k] > slow_cosine ? 1u : 0u) << k;
  // An edge axis that is a face's too must not win by its rounding: the face's formula is the more exact one.
  double least = 1e-15 * x.size();
  for (; hopeful != 0; hopeful &= hopeful - 1) {
    const int k = std::countr_zero(hopeful), i = k / 3, j = k % 3;
    const double length2 = x.edge_length2(i, j);
    if (length2 > slow2 && numerator[k] * std::abs(numerator[k]) <= best.distance * std::abs(best.distance) * length2)
      continue;
    const double s = x.along_edge(i, j);
    if (s > best.distance + least) best = {s, 6 + k}, least = 0;
  }
  return best;
}

/// Witness points of boxes that overlap, from the axis; false where they do not follow from it.
bool witness(const Boxes& x, int axis, LocalAnswer& answer) {
  const Vec3& n = answer.normal;
  const double s = answer.signed_distance;
  const Vec3 a{x.a[0], x.a[1], x.a[2]}, b{x.b[0], x.b[1], x.b[2]}, t = x.translation();
  const Mat3 r = x.rotation();
  if (axis < 3) {
    const bool paired = over_face(a, axis, n, b, r, t, answer.point_b);
    answer.point_a = answer.point_b - s * n;
    return paired;
  }
  if (axis < 6) {
    const Mat3 back = r.transpose();
    Vec3 in_b;
    const bool paired = over_face(b, axis - 3, -(back * n), a, back, -(back * t), in_b);
    answer.point_a = t + r * in_b;
    answer.point_b = answer.point_a + s * n;
    return paired;
  }
  const int i = (axis - 6) / 3, j = (axis - 6) % 3;
  const Vec3 m = r.transpose() * n;
  Vec3 ca, cb;
  for (int k = 0; k < 3; ++k) {
    ca[k] = k == i ? 0.0 : std::copysign(a[k], n[k]);
    cb[k] = k == j ? 0.0 : -std::copysign(b[k], m[k]);
  }
  const SegmentDistance d = segment_distance(ca, a[i] * Vec3::Unit(i), t + r * cb, b[j] * r.col(j));
  answer.point_a = d.point_a;
  answer.point_b = d.point_a + s * n;
  return (d.point_b - answer.point_b).squaredNorm() <= rounding2 * (a + b).squaredNorm();
}

/// Nearest points of boxes that are apart: minimises the distance of B's point u (in B's frame) from A, one of u's
/// coordinates at a time and exactly in each, from the corner the axis points to. Ends where no coordinate wants to
/// move, which proves the minimum; false if that takes too long.
bool nearest_points(const Boxes& x, const Vec3& n, Vec3& point_a, Vec3& point_b) {
  const double tolerance = 5e-16 * x.size();
  double u[3];
  for (int k = 0; k < 3; ++k) u[k] = -std::copysign(x.b[k], n[0] * x.r[0][k] + n[1] * x.r[1][k] + n[2] * x.r[2][k]);
  bool projected = false;
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 3; ++i) {
      point_b[i] = x.t[i] + (x.r[i][0] * u[0] + x.r[i][1] * u[1] + x.r[i][2] * u[2]);
      point_a[i] = std::clamp(point_b[i], -x.a[i], x.a[i]);
    }
    const Vec3 w = point_b - point_a;
    int moves = 0, fastest = 0;
    double most = tolerance;
    for (int k = 0; k < 3; ++k) {
      const double v = w[0] * x.r[0][k] + w[1] * x.r[1][k] + w[2] * x.r[2][k];
      if (!(std::abs(v) > tolerance) || u[k] == -std::copysign(x.b[k], v)) continue;
      ++moves;
      if (std::abs(v) > most) most = std::abs(v), fastest = k;
    }
    if (moves == 0) return true;
    if (moves > 1 && !projected) {
      // A corner of A over the inside of B's face, perhaps.
      for (int k = 0; k < 3; ++k) {
        double in_b = 0;
        for (int i = 0; i < 3; ++i) in_b += x.r[i][k] * (point_a[i] - x.t[i]);
        u[k] = std::clamp(in_b, -x.b[k], x.b[k]);
      }
      projected = true;
      continue;
    }
    projected = false;
    const Vec3 along{x.r[0][fastest], x.r[1][fastest], x.r[2][fastest]};
    u[fastest] =
        nearest_on_line({x.a[0], x.a[1], x.a[2]}, point_b - u[fastest] * along, along, x.b[fastest], u[fastest]);
  }
  return false;
}

}  // namespace

bool box_box_collide(const Vec3& a, const Pose& pose_a, const Vec3& b, const Pose& pose_b) {
  Boxes x;
  x.place(a, pose_a, b, pose_b);
  if (std::max({x.face_of_a(0), x.face_of_a(1), x.face_of_a(2)}) > 0) return false;
  if (std::max({x.face_of_b(0), x.face_of_b(1), x.face_of_b(2)}) > 0) return false;
  double least = -std::numeric_limits<double>::infinity();
  double parallel = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      least = std::max(least, x.edge(i, j));
      parallel = std::max(parallel, x.q[i][j]);
    }
  const double doubt = rounding * x.size();
  if (least < -doubt && parallel <= slow_cosine) return true;
  return !edges_separate(x, doubt);
}

BoxAnswer box_box_distance(const Vec3& a, const Pose& pose_a, const Vec3& b, const Pose& pose_b) {
  Boxes x;
  x.place(a, pose_a, b, pose_b);
  const Separation best = separation(x);
  BoxAnswer answer;
  Vec3& n = answer.local.normal;
  answer.axis = best.axis;
  if (best.axis < 3) {
    n = Vec3::Unit(best.axis);
  } else if (best.axis < 6) {
    n = {x.r[0][best.axis - 3], x.r[1][best.axis - 3], x.r[2][best.axis - 3]};
  } else {
    const int i = (best.axis - 6) / 3, j = (best.axis - 6) % 3;
    n = x.edge_axis(i, j, std::sqrt(x.edge_length2(i, j)));
  }
  if (n[0] * x.t[0] + n[1] * x.t[1] + n[2] * x.t[2] < 0) n = -n;
  answer.local.signed_distance = best.distance;
  if (best.distance <= 0) {
    // Parallel faces and edges: many corners are equally deep, and not all of them lie over the other box.
    if (!witness(x, best.axis, answer.local)) {
      const ConvexView va = view_box(a), vb = view_box(b);
      pair_points({va, vb, {x.rotation(), x.translation()}}, answer.local);
    }
    return answer;
  }
  LocalAnswer& local = answer.local;
  double upper;
  Vec3 direction = n;
  if (nearest_points(x, n, local.point_a, local.point_b)) {
    direction = local.point_b - local.point_a;
    upper = direction.norm();
    direction /= upper;
  } else {
    const ConvexView va = view_box(a), vb = view_box(b);
    local = gjk_signed_distance({va, vb, {x.rotation(), x.translation()}}, 0);
    upper = local.signed_distance;
    direction = local.normal;
    local.normal = n;
  }
  // Where the axis says as much, it is exact, and the direction between nearest points that touch nearly is noise.
  if (upper - best.distance > rounding * x.size()) {
    local.signed_distance = upper;
    local.normal = direction;
    answer.axis = -1;
  } else {
    local.signed_distance = best.distance;
    local.gap = 0;
  }
  return answer;
}

}  // namespace tandem
