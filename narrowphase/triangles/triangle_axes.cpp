// Collision verdicts of triangles and boxes by separating axes.
#include "triangles/triangle_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shapes/support.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// Error bound of separations along axes of any length, which are products of up to three lengths, relative to those. A
/// dozen times the largest observed.
constexpr double rounding = 64 * epsilon;

/// Transforms B's corners into A's frame; returns the largest number involved.
double place(std::span<const Vec3, 3> b, const Pose& pose_a, const Pose& pose_b, Vec3* out) {
  const RelativePose pose = relative(pose_a, pose_b);
  double reach = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 turned = pose.rotation * b[k];
    out[k] = turned + pose.translation;
    reach = std::max(reach, b[k].cwiseAbs().maxCoeff());
  }
  return 2 * reach + pose.translation.cwiseAbs().maxCoeff();
}

/// The gap between [a0, a1] and [b0, b1], whose ends are in any order; negative: they overlap.
double gap(double a0, double a1, double b0, double b1) {
  return std::max(std::min(b0, b1) - std::max(a0, a1), std::min(a0, a1) - std::max(b0, b1));
}

}  // namespace

std::optional<bool> triangles_collide(std::span<const Vec3, 3> a, const Pose& pose_a, std::span<const Vec3, 3> b,
                                      const Pose& pose_b) {
  Vec3 q[3];
  const double reach = place(b, pose_a, pose_b, q) + a[0].cwiseAbs().maxCoeff();
  // Relative to A's first corner: p[0] is the origin.
  const Vec3 p[3] = {Vec3::Zero(), a[1] - a[0], a[2] - a[0]};
  for (Vec3& corner : q) corner -= a[0];
  const Vec3 lo = q[0].cwiseMin(q[1]).cwiseMin(q[2]).cwiseMin(p[1].cwiseMin(p[2]).cwiseMin(0.0));
  const Vec3 hi = q[0].cwiseMax(q[1]).cwiseMax(q[2]).cwiseMax(p[1].cwiseMax(p[2]).cwiseMax(0.0));
  const double extent = (hi - lo).maxCoeff();
  const double doubt = rounding * (reach + extent) * extent * extent;

  const Vec3 e[3] = {p[1], p[2] - p[1], -p[2]}, f[3] = {q[1] - q[0], q[2] - q[1], q[0] - q[2]};
  const Vec3 normal_a = e[0].cross(e[1]), normal_b = f[0].cross(f[1]);
  // The corners of each relative to the other's plane.
  const double q0 = normal_a.dot(q[0]), q1 = normal_a.dot(q[1]), q2 = normal_a.dot(q[2]);
  const double over_a = std::max(std::min({q0, q1, q2}), -std::max({q0, q1, q2}));
  if (over_a > doubt) return false;
  const double p0 = -normal_b.dot(q[0]), p1 = normal_b.dot(p[1] - q[0]), p2 = normal_b.dot(p[2] - q[0]);
  const double over_b = std::max(std::min({p0, p1, p2}), -std::max({p0, p1, p2}));
  if (over_b > doubt) return false;

  // Along e_i x f_j each edge projects to one number; its triangle's third corner differs by f_j . normal_a or e_i .
  // normal_b.
  Vec3 moment_a[3], moment_b[3];
  double beside_a[3], beside_b[3];
  for (int i = 0; i < 3; ++i) {
    moment_a[i] = p[i].cross(e[i]);
    moment_b[i] = f[i].cross(q[i]);
    beside_a[i] = -f[i].dot(normal_a);
    beside_b[i] = e[i].dot(normal_b);
  }
  double most = std::max(over_a, over_b);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double from_a = e[i].dot(moment_b[j]) - f[j].dot(moment_a[i]);
      most = std::max(most, gap(0, beside_a[j], from_a, from_a + beside_b[i]));
    }
  if (most > doubt) return false;
  if (most < -doubt) return true;
  return std::nullopt;
}

std::optional<bool> box_triangle_collide(const std::array<double, 4>& half, const Pose& pose_a,
                                         std::span<const Vec3, 3> b, const Pose& pose_b) {
  using Array = Eigen::Array3d;
  Vec3 q[3];
  const Array h(half[0], half[1], half[2]);
  const double reach = rounding * (place(b, pose_a, pose_b, q) + h.maxCoeff());
  const Array lo = q[0].cwiseMin(q[1]).cwiseMin(q[2]), hi = q[0].cwiseMax(q[1]).cwiseMax(q[2]);
  const double faces = (lo.max(-hi) - h).maxCoeff();
  if (faces > reach) return false;
  const Vec3 middle = (q[0] + q[1] + q[2]) / 3;
  if ((middle.array().abs() - h).maxCoeff() < -reach) return true;

  const Vec3 f[3] = {q[1] - q[0], q[2] - q[1], q[0] - q[2]};
  const Array length[3] = {f[0].cwiseAbs(), f[1].cwiseAbs(), f[2].cwiseAbs()};
  const double longest = length[0].max(length[1]).max(length[2]).maxCoeff();
  const Vec3 normal = f[0].cross(f[1]);
  const double plane = std::abs(normal.dot(q[0])) - (h * normal.array().abs()).sum();
  const double plane_doubt = reach * longest * longest;
  if (plane > plane_doubt) return false;

  // Along the cross product of a box's axis and an edge, the edge projects to one number; the third corner differs by
  // the normal's coordinate.
  Array most = Array::Constant(-std::numeric_limits<double>::infinity());
  for (int j = 0; j < 3; ++j) {
    const Array at = f[j].cross(q[j]), other = at + normal.array();
    const Array& l = length[j];
    const Array across(h[1] * l[2] + h[2] * l[1], h[2] * l[0] + h[0] * l[2], h[0] * l[1] + h[1] * l[0]);
    most = most.max(at.min(other).max(-at.max(other)) - across);
  }
  const double edges = most.maxCoeff(), edge_doubt = reach * longest;
  if (edges > edge_doubt) return false;
  if (faces < -reach && plane < -plane_doubt && edges < -edge_doubt) return true;
  return std::nullopt;
}

}  // namespace tandem
