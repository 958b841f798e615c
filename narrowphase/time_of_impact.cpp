#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "mesh_model.h"
#include "solvers.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();
constexpr int max_advances = 200;

/// First time in [from, until] at which two convex shapes touch, B translating by `velocity` as A sees it.
/// The separating plane found at one time bounds the distance at all later ones, so every advance is safe, and
/// because the distance is a convex function of time the advances converge from below like Newton's.
double convex_impact(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b,
                     const Vec3& velocity, double until) {
  const NarrowPhaseOptions exact;
  const double rounding = 1e-14 * (a.size + b.size);
  double time = 0;
  Pose moved = pose_b;
  for (int i = 0; i < max_advances; ++i) {
    moved.translation = pose_b.translation + time * velocity;
    const PairAnswer answer = solve_convex(a, pose_a, b, moved, Request::distance, exact, nullptr);
    if (answer.signed_distance <= rounding) return time;
    const double closing = -answer.normal.dot(velocity);
    if (!(closing > 0)) return never;
    const double next = time + answer.signed_distance / closing;
    if (next > until) {
      // The last bits of the end of the interval belong to it.
      if (next > until * (1 + 1e-12)) return never;
      return until;
    }
    if (next <= time) return time;
    time = next;
  }
  return time;  // creeping up on a graze: early, never late
}

/// A piece of a shape that is convex: the shape, or one triangle of a mesh; with its box in world axes.
struct Piece {
  ConvexView view;
  Bounds box;
};

std::vector<Piece> pieces(const Shape& shape, const Pose& pose, std::vector<std::array<Vec3, 3>>& corners) {
  std::vector<Piece> list;
  if (shape.is_convex()) {
    list.push_back({view(shape), shape.bounds(pose)});
    return list;
  }
  const MeshModel& mesh = shape.mesh();
  corners.reserve(mesh.triangles.size());
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    corners.push_back(mesh.corners(i));
    const Vec3 p = pose * corners[i][0], q = pose * corners[i][1], r = pose * corners[i][2];
    list.push_back({view_triangle(corners[i]), {p.cwiseMin(q).cwiseMin(r), p.cwiseMax(q).cwiseMax(r)}});
  }
  return list;
}

/// When the boxes begin to overlap; `never` if they do not within `until`. Widened by rounding.
double boxes_meet(const Bounds& a, const Bounds& b, const Vec3& velocity, double until) {
  double enter = 0, leave = until;
  for (int k = 0; k < 3; ++k) {
    const double slack = 1e-12 * (std::abs(a.lo[k]) + std::abs(a.hi[k]) + std::abs(b.lo[k]) + std::abs(b.hi[k]) +
                                  std::abs(velocity[k]) * until);
    const double ahead = a.lo[k] - b.hi[k] - slack, behind = a.hi[k] - b.lo[k] + slack;  // B must move by this
    if (velocity[k] == 0) {
      if (ahead > 0 || behind < 0) return never;
      continue;
    }
    const double t0 = ahead / velocity[k], t1 = behind / velocity[k];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return enter <= leave ? enter : never;
}

Bounds united(const std::vector<Piece>& list) {
  Bounds all = list.front().box;
  for (const Piece& p : list) {
    all.lo = all.lo.cwiseMin(p.box.lo);
    all.hi = all.hi.cwiseMax(p.box.hi);
  }
  return all;
}

}  // namespace

std::optional<double> NarrowPhase::time_of_impact(const Shape& a, const Pose& pose_a, const Vec3& velocity_a,
                                                  const Shape& b, const Pose& pose_b, const Vec3& velocity_b,
                                                  double tmax) const {
  if (!std::isfinite(tmax) || tmax < 0)
    throw std::invalid_argument("tmax: " + std::to_string(tmax) + " is not finite and >= 0");
  if (!velocity_a.allFinite() || !velocity_b.allFinite())
    throw std::invalid_argument("velocity: not finite, every component must be");
  if (const std::string why = refuses(a, b, Request::distance); !why.empty()) throw std::invalid_argument(why);
  if (solve(a, pose_a, b, pose_b, Request::collide).collide) return 0.0;
  const Vec3 velocity = velocity_b - velocity_a;

  std::vector<std::array<Vec3, 3>> corners_a, corners_b;
  const std::vector<Piece> list_a = pieces(a, pose_a, corners_a), list_b = pieces(b, pose_b, corners_b);
  const Bounds all_b = united(list_b);
  double first = never;
  for (const Piece& pa : list_a) {
    if (boxes_meet(pa.box, all_b, velocity, tmax) >= first) continue;
    for (const Piece& pb : list_b) {
      if (boxes_meet(pa.box, pb.box, velocity, tmax) >= first) continue;
      const double until = std::min(first, tmax);
      first = std::min(first, convex_impact(pa.view, pose_a, pb.view, pose_b, velocity, until));
    }
  }
  if (first == never) return std::nullopt;
  return first;
}

}  // namespace tandem
