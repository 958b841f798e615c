// The distance of two boxes by separating axes (Gottschalk 1996).
#include "boxes/box_box.h"

#include <bit>
#include <limits>

#include "boxes/segment_box.h"
#include "closed_forms/closed_forms.h"
#include "convex/feature_normals.h"
#include "convex/gjk.h"
#include "shapes/cyclic.h"
#include "tolerances.h"

namespace tandem {
namespace {

double size(const BoxAxes& x) { return x.a[0] + x.a[1] + x.a[2] + x.b[0] + x.b[1] + x.b[2]; }

/// The squared length of a_i x b_j.
double edge_length2(const BoxAxes& x, int i, int j) {
  const double y = x.r[next_of_three[i]][j], z = x.r[last_of_three[i]][j];
  return y * y + z * z;
}

/// The unit vector along a_i x b_j, in A's frame.
Vec3 edge_axis(const BoxAxes& x, int i, int j) {
  const double length = std::sqrt(edge_length2(x, i, j));
  Vec3 n = Vec3::Zero();
  n[next_of_three[i]] = -x.r[last_of_three[i]][j] / length;
  n[last_of_three[i]] = x.r[next_of_three[i]][j] / length;
  return n;
}

/// The separation along an edge axis, by projecting both boxes; never more than the signed distance, to rounding.
double along_edge(const BoxAxes& x, int i, int j) {
  if (!(edge_length2(x, i, j) > tolerance::parallel_edges2)) return -std::numeric_limits<double>::infinity();
  const Vec3 n = edge_axis(x, i, j);
  const int i1 = next_of_three[i], i2 = last_of_three[i];
  double s = std::abs(n[i1] * x.t[i1] + n[i2] * x.t[i2]) - (x.a[i1] * std::abs(n[i1]) + x.a[i2] * std::abs(n[i2]));
  for (const int k : {next_of_three[j], last_of_three[j]})
    s -= x.b[k] * std::abs(n[i1] * x.r[i1][k] + n[i2] * x.r[i2][k]);
  return s;
}

/// True if an edge axis decides, at least one of them too close to call by the short formula.
bool edges_separate(const BoxAxes& x, double doubt) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if ((x.q[i][j] > nearly_parallel || x.edge[i][j] > -doubt) && along_edge(x, i, j) > 0) return true;
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
    if (std::abs(m[k]) <= tolerance::in_face) free[frees++] = k;
  }
  const int u = next_of_three[axis], w = last_of_three[axis];
  const double slack = tolerance::on_feature * (a.sum() + b.sum());
  point = t + r * corner;
  if (std::abs(point[u]) <= a[u] && std::abs(point[w]) <= a[w]) return true;
  if (frees == 0) return std::abs(point[u]) <= a[u] + slack && std::abs(point[w]) <= a[w] + slack;
  for (int i = 0; i < frees * frees; ++i) {  // the edge, or the four edges of the face
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
  // No edge of b's face crosses a's face: one lies within the other, or they miss by rounding.
  const double height = point[axis];
  point.setZero();
  point[axis] = height;
  return ((r.transpose() * (point - t)).cwiseAbs().array() <= b.array() + slack).all();
}

/// The axis of largest separation, and the separation.
struct Separation {
  double distance;
  int axis;  ///< 0-2: A's faces, 3-5: B's, 6 + 3 i + j: a_i x b_j
};

Separation best_separation(const BoxAxes& x) {
  Separation best{x.face_of_a[0], 0};
  for (int k = 1; k < 6; ++k) {
    const double s = k < 3 ? x.face_of_a[k] : x.face_of_b[k - 3];
    if (s > best.distance) best = {s, k};
  }
  // An edge axis that coincides with a face normal must not win by its rounding: the face's formula is the more exact
  // one.
  double least = tolerance::tie * size(x);
  for (unsigned hopeful = x.hopeful; hopeful != 0; hopeful &= hopeful - 1) {
    const int k = std::countr_zero(hopeful), i = k / 3, j = k % 3;
    const double length2 = edge_length2(x, i, j), now = best.distance, numerator = x.edge[i][j];
    if (length2 > tolerance::clearly_crossing2 && numerator * std::abs(numerator) <= now * std::abs(now) * length2)
      continue;
    const double s = along_edge(x, i, j);
    if (s > now + least) best = {s, 6 + k}, least = 0;
  }
  return best;
}

/// The component of n along B's axis k; summed as in the kernel for several pairs, as its sign may be that of rounding.
double along_axis_of_b(const BoxAxes& x, const Vec3& n, int k) {
  return n[0] * x.r[0][k] + (n[1] * x.r[1][k] + n[2] * x.r[2][k]);
}

/// The points of edge i of A and edge j of B where they pass each other along the normal.
bool edges_witness(const BoxAxes& x, int i, int j, LocalAnswer& answer) {
  const Vec3& n = answer.normal;
  const double s = answer.signed_distance;
  const int i1 = next_of_three[i], i2 = last_of_three[i], j1 = next_of_three[j], j2 = last_of_three[j];
  // The edges' other coordinates, each in its own box; B's point is the one farthest against the normal.
  const auto against = [&](int k) { return -std::copysign(x.b[k], along_axis_of_b(x, n, k)); };
  const double b1 = against(j1), b2 = against(j2);
  const auto on_line = [&](int k) { return x.t[k] + (x.r[k][j1] * b1 + x.r[k][j2] * b2); };
  const double a1 = std::copysign(x.a[i1], n[i1]), a2 = std::copysign(x.a[i2], n[i2]);
  const double w1 = on_line(i1) - a1, w2 = on_line(i2) - a2, y = x.r[i1][j], z = x.r[i2][j];
  const double slack = tolerance::on_feature * size(x);
  double on_b = -(w1 * y + w2 * z) / (y * y + z * z);
  double on_a = on_line(i) + on_b * x.r[i][j];
  if (!(std::abs(on_a) <= x.a[i] + slack && std::abs(on_b) <= x.b[j] + slack)) return false;
  on_a = std::clamp(on_a, -x.a[i], x.a[i]);
  on_b = std::clamp(on_b, -x.b[j], x.b[j]);
  answer.point_a[i] = on_a;
  answer.point_a[i1] = a1;
  answer.point_a[i2] = a2;
  answer.point_b = answer.point_a + s * n;
  // On nearly parallel edges rounding moves the points far along both: together, or the result is invalid.
  double off2 = 0;
  for (int k = 0; k < 3; ++k) {
    const double off = on_line(k) + on_b * x.r[k][j] - answer.point_b[k];
    off2 += off * off;
  }
  return off2 <= slack * slack;
}

/// The witness points, where they follow from the axis of the normal: then the axis' separation is the distance.
bool witness(const BoxAxes& x, int axis, LocalAnswer& answer) {
  const Vec3& n = answer.normal;
  const double s = answer.signed_distance;
  const Vec3 a{x.a[0], x.a[1], x.a[2]}, b{x.b[0], x.b[1], x.b[2]}, t{x.t[0], x.t[1], x.t[2]};
  Mat3 r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r(i, j) = x.r[i][j];
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
  return edges_witness(x, (axis - 6) / 3, (axis - 6) % 3, answer);
}

/// The nearest points of separated boxes: minimises the distance of B's point u (in B's frame) from A by exact line
/// searches along one of u's coordinates at a time, from the corner the axis points to. Ends when no coordinate
/// changes, which proves the minimum; false if that takes too long.
bool nearest_points(const BoxAxes& x, const Vec3& n, Vec3& point_a, Vec3& point_b) {
  const double enough = tolerance::box_points * size(x);
  double u[3];
  for (int k = 0; k < 3; ++k) u[k] = -std::copysign(x.b[k], along_axis_of_b(x, n, k));
  bool projected = false;
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 3; ++i) {
      point_b[i] = x.t[i] + (x.r[i][0] * u[0] + x.r[i][1] * u[1] + x.r[i][2] * u[2]);
      point_a[i] = std::clamp(point_b[i], -x.a[i], x.a[i]);
    }
    const Vec3 w = point_b - point_a;
    int moves = 0, fastest = 0;
    double most = enough;
    for (int k = 0; k < 3; ++k) {
      const double v = w[0] * x.r[0][k] + w[1] * x.r[1][k] + w[2] * x.r[2][k];
      if (!(std::abs(v) > enough) || u[k] == -std::copysign(x.b[k], v)) continue;
      ++moves;
      if (std::abs(v) > most) most = std::abs(v), fastest = k;
    }
    if (moves == 0) return true;
    if (moves > 1 && !projected) {
      // Possibly a corner of A over the interior of B's face.
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

Vec3 axis_direction(const BoxAxes& x, int axis) {
  Vec3 n;
  if (axis < 3)
    n = Vec3::Unit(axis);
  else if (axis < 6)
    n = {x.r[0][axis - 3], x.r[1][axis - 3], x.r[2][axis - 3]};
  else
    n = edge_axis(x, (axis - 6) / 3, (axis - 6) % 3);
  return n[0] * x.t[0] + (n[1] * x.t[1] + n[2] * x.t[2]) < 0 ? Vec3(-n) : n;
}

/// Sets what the manifold builder needs of an edge axis.
void describe_edges(const BoxAxes& x, BoxAnswer& answer) {
  if (answer.axis < 6) return;
  const Vec3& n = answer.local.normal;
  answer.edges_cosine = std::abs(x.r[(answer.axis - 6) / 3][(answer.axis - 6) % 3]);
  answer.facing = n.cwiseAbs().maxCoeff();
  for (int k = 0; k < 3; ++k)
    answer.facing = std::max(answer.facing, std::abs(along_axis_of_b(x, n, k)));
}

RelativePose relative_pose(const BoxAxes& x) {
  RelativePose pose;
  for (int i = 0; i < 3; ++i) {
    pose.translation[i] = x.t[i];
    for (int j = 0; j < 3; ++j) pose.rotation(i, j) = x.r[i][j];
  }
  return pose;
}

/// Two boxes in the form of general convex solvers.
struct Boxes {
  Boxes(const HalfSize& half_a, const HalfSize& half_b, const BoxAxes& x)
      : a(view_box(half_a)), b(view_box(half_b)), difference{a, b, relative_pose(x)} {}
  Boxes(const Boxes&) = delete;
  Boxes& operator=(const Boxes&) = delete;

  ConvexView a, b;
  MinkowskiDifference difference;
};

}  // namespace

bool box_box_collide(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b) {
  BoxAxes x;
  if (measure_axes(a.data(), &pose_a, b.data(), &pose_b, 0, &x)) return false;
  const double doubt = tolerance::axis_rounding * size(x);
  if (x.most_edge < -doubt && x.most_cosine <= nearly_parallel) return true;
  return !edges_separate(x, doubt);
}

BoxAnswer box_box_distance(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b) {
  BoxAxes x;
  measure_axes(a.data(), &pose_a, b.data(), &pose_b, std::numeric_limits<double>::infinity(), &x);
  const Separation best = best_separation(x);
  BoxAnswer answer;
  LocalAnswer& local = answer.local;
  answer.axis = best.axis;
  local.signed_distance = best.distance;
  local.normal = axis_direction(x, best.axis);
  if (witness(x, best.axis, local)) return answer;

  const Vec3 axis = local.normal;
  if (best.distance <= 0) {
    // With parallel faces and edges many corners are equally deep, and not all of them lie over the other box.
    pair_points(Boxes(a, b, x).difference, local);
    return answer;
  }
  double upper;
  Vec3 direction;
  if (nearest_points(x, axis, local.point_a, local.point_b)) {
    direction = local.point_b - local.point_a;
    upper = direction.norm();
    // Rotations that are not quite orthonormal may bring both points to one place though the axis separates.
    direction = upper > 0 ? Vec3(direction / upper) : axis;
  } else {
    const Boxes boxes(a, b, x);
    const GjkResult r = gjk(boxes.difference, tolerance::axis_rounding);
    upper = r.upper;
    direction = r.normal(tolerance::place_rounding * size(x));
    set_points(r.simplex, local);
  }
  // If the axis gives the same distance and the points lie along it, the axis is exact, and the direction between
  // points that nearly touch is noise.
  const double doubt = tolerance::axis_rounding * size(x);
  const bool equal = !(upper - best.distance > doubt);
  if (equal && (local.point_b - local.point_a - best.distance * axis).norm() <= tolerance::on_feature * size(x)) {
    local.signed_distance = best.distance;
    local.normal = axis;
    local.gap = 0;
    return answer;
  }
  local.signed_distance = upper;
  local.normal = direction;
  answer.axis = -1;
  if (equal || upper < tolerance::nearly_touching_boxes * size(x)) {
    const Boxes boxes(a, b, x);
    const double along = separation_along(boxes.difference, direction);
    if (along < upper - doubt) {
      // The direction between points that nearly touch is arbitrary, while the axis is known to separate.
      if (separation_along(boxes.difference, axis) > along) local.normal = axis;
      settle_by_features(boxes.difference, local);
    }
  }
  return answer;
}

BoxAnswer box_box_overlap(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b,
                          const BoxAxes& x, double margin) {
  BoxAnswer answer;
  const Separation best = best_separation(x);
  if (best.distance > 0 && best.distance <= margin) {
    answer = box_box_distance(a, pose_a, b, pose_b);
    describe_edges(x, answer);
    return answer;
  }
  answer.axis = best.axis;
  answer.local.signed_distance = best.distance;
  answer.local.normal = axis_direction(x, best.axis);
  if (best.axis < 6) return answer;
  describe_edges(x, answer);
  if (best.distance <= 0 && !edges_witness(x, (best.axis - 6) / 3, (best.axis - 6) % 3, answer.local))
    pair_points(Boxes(a, b, x).difference, answer.local);
  return answer;
}

}  // namespace tandem
