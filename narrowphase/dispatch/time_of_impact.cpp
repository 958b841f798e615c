// Time of impact of two bodies on straight lines: conservative advancement, on meshes best first over their
// hierarchies.
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <stdexcept>
#include <string>

#include "dispatch/swept_body.h"
#include "meshes/mesh_solvers.h"
#include "pairs/convex_pair.h"
#include "shapes/voxel_reach.h"
#include "shapes/written.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tolerances.h"

namespace tandem {
namespace {

// Advances are lengths along B's unit direction of motion relative to A: they do not depend on the speed.

// A body with the axes of its pose.
struct Body : SweptBody {
  Mat3 rotation;
  Body(const Shape& shape, const Pose& pose, const WorkLimit* limit)
      : SweptBody(shape, limit), rotation(pose.rotation) {}
};

class Sweep {
 public:
  /// `radius`: the sum of both shapes' rounding.
  Sweep(const Body& a, const Body& b, const Vec3& between, const Vec3& along, double longest, double radius,
        const WorkLimit* limit)
      : meter_(limit),
        a_(a),
        b_(b),
        between_(between),
        along_(along),
        longest_(longest),
        radius_(radius),
        map_(a.rotation.transpose() * b.rotation) {
    shift_ = a.rotation.transpose() * between;
    in_a_ = a.rotation.transpose() * along;
    in_b_ = b.rotation.transpose() * along;
    const auto reach = [](const Body& s) { return (s.mid.cwiseAbs() + s.half).maxCoeff(); };
    const auto skew = [](const Mat3& r) { return (r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff(); };
    coordinates_ = reach(a) + reach(b) + between.norm();
    // Rotations may not be quite orthonormal, and coordinates are rounded.
    slack_ = radius + (tolerance::place_rounding + 4 * (skew(a.rotation) + skew(b.rotation))) * coordinates_;
  }

  // The advance until the first contact; `never` if there is none within the longest.
  double first() {
    double best = never;
    std::priority_queue<Item> queue;
    const auto push = [&](std::uint32_t x, std::uint32_t y) {
      if (const double advance = boxes_meet(x, y, std::min(best, longest_)); advance < best)
        queue.push({advance, x, y});
    };
    push(a_.root(), b_.root());
    while (!queue.empty() && queue.top().bound < best) {
      meter_.spend(16);
      const Item top = queue.top();
      queue.pop();
      const bool leaf_a = a_.is_leaf(top.a), leaf_b = b_.is_leaf(top.b);
      if (leaf_a && leaf_b) {
        a_.each_convex(top.a, [&](const ConvexView& p, const Vec3& origin_p, std::uint32_t) {
          b_.each_convex(top.b, [&](const ConvexView& q, const Vec3& origin_q, std::uint32_t) {
            best = std::min(best, convex_meet(p, origin_p, q, origin_q, top.bound, std::min(best, longest_)));
          });
        });
      } else if (leaf_b || (!leaf_a && a_.box(top.a).second.norm() >= b_.box(top.b).second.norm())) {
        a_.each_child_of(top.a, [&](std::uint32_t x) { push(x, top.b); });
      } else {
        b_.each_child_of(top.b, [&](std::uint32_t y) { push(top.a, y); });
      }
    }
    return best;
  }

 private:
  // Conservative advancement (Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996). The plane that
  // separates the two at one place bounds their distance at all later ones, so no advance is too far, and the distance
  // being a convex function of the advance, the advances converge from below like Newton's.
  double convex_meet(const ConvexView& p, const Vec3& origin_p, const ConvexView& q, const Vec3& origin_q, double from,
                     double until) {
    constexpr int most_advances = 200;
    const NarrowPhaseOptions exact;
    // As far as coordinates are rounded: a point that comes in through an edge must not pass between its two triangles.
    const double rounding = tolerance::touch * (p.size + q.size + radius_ + coordinates_);
    const Pose at_a{a_.rotation, a_.rotation * origin_p};
    const Vec3 start_b = between_ + b_.rotation * origin_q;
    double advance = from;
    for (int i = 0; i < most_advances; ++i) {
      meter_.spend(work_of_advance(p, q));
      const Pose at_b{b_.rotation, start_b + advance * along_};
      const PairAnswer answer = solve_convex(p, at_a, q, at_b, Request::distance, exact, nullptr);
      const double gap = answer.signed_distance - radius_;
      if (gap <= rounding) return advance;
      const double closing = -answer.normal.dot(along_);
      if (!(closing > 0)) return never;
      const double next = advance + gap / closing;
      if (!(next <= until)) {
        // The last part of the motion counts as its end: shapes that are that near there touch.
        if (until < longest_ || !(next <= longest_ * (1 + tolerance::end_of_motion))) return never;
        if (advance == until) return until;
        advance = until;
        continue;
      }
      if (next <= advance) return advance;
      advance = next;
    }
    return advance;  // creeping up on a graze: early, never late
  }

  // The advance until two boxes of the hierarchies overlap along the axes of both; `never` if not within `until`.
  double boxes_meet(std::uint32_t x, std::uint32_t y, double until) const {
    const auto [mid_a, half_a] = a_.box(x);
    const auto [mid_b, half_b] = b_.box(y);
    const Vec3 d = map_ * mid_b + shift_ - mid_a;
    double enter = 0, leave = until;
    const auto clip = [&](double offset, double extent, double speed) {
      const double wide = extent + slack_ + tolerance::outward * until * std::abs(speed);
      if (speed == 0) {
        if (std::abs(offset) > wide) leave = -1;
        return;
      }
      const double middle = -offset / speed, span = wide / std::abs(speed);
      enter = std::max(enter, middle - span);
      leave = std::min(leave, middle + span);
    };
    const Vec3 sum_a = half_a + map_.cwiseAbs() * half_b, sum_b = half_b + map_.cwiseAbs().transpose() * half_a;
    const Vec3 d_b = map_.transpose() * d;
    for (int k = 0; k < 3; ++k) {
      clip(d[k], sum_a[k], in_a_[k]);
      clip(d_b[k], sum_b[k], in_b_[k]);
    }
    return enter <= leave ? enter : never;
  }

  WorkMeter meter_;
  const Body &a_, &b_;
  const Vec3 between_, along_;
  const double longest_, radius_;
  const Mat3 map_;  // from B's frame into A's
  Vec3 shift_, in_a_, in_b_;
  double coordinates_;  // the magnitude of the largest coordinates in the computation
  double slack_;
};

struct ClosingGap {
  double gap;
  double closing;  ///< per metre that B moves along `along`
};

/// The gap of a mesh and a plane: for a mesh on both sides of it, only triangles that move towards it count.
ClosingGap gap_of_mesh_and_plane(const Posed& mesh, const Posed& plane, const Vec3& along, double radius,
                                 const WorkLimit* limit) {
  const PlaneInMesh seen(mesh.pose, plane);
  const PlaneGaps gaps = plane_gaps(mesh_of(mesh.shape), seen, limit);
  const double rising = seen.up.dot(along);
  return {(gaps.cut ? 0 : rising < 0 ? gaps.above : gaps.below) - radius, std::abs(rising)};
}

/// The same of voxels.
ClosingGap gap_of_voxels_and_plane(const Posed& voxels, const Posed& plane, const Vec3& along, double radius,
                                   const WorkLimit* limit) {
  const PlaneInMesh seen(voxels.pose, plane);
  const VoxelModel& model = voxels_of(voxels.shape);
  const double rising = seen.up.dot(along), sense = rising < 0 ? 1 : -1;
  WorkMeter meter(limit);
  // Parts that lie behind the moving plane have been passed by it.
  const double nearest = -greatest_of_cells(
      model,
      [&](VoxelRef ref) {
        const auto [mid, half] = model.box(ref);
        const double height = sense * (seen.local.dot(mid) - seen.level), reach = seen.local.cwiseAbs().dot(half);
        return height + reach > 0 ? reach - height : -infinity;
      },
      meter);
  return {std::max(nearest, 0.0) - radius, std::abs(rising)};
}

ClosingGap gap_to_unbounded(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& along,
                            const NarrowPhaseOptions& options) {
  const double radius = a.rounding() + b.rounding();
  if (b.kind() == ShapeKind::voxels && a.kind() == ShapeKind::plane)
    return gap_of_voxels_and_plane({b, pose_b}, {a, pose_a}, along, radius, options.limit);
  if (a.kind() == ShapeKind::voxels && b.kind() == ShapeKind::plane)
    return gap_of_voxels_and_plane({a, pose_a}, {b, pose_b}, -along, radius, options.limit);
  if (!b.is_convex() && a.kind() == ShapeKind::plane)
    return gap_of_mesh_and_plane({b, pose_b}, {a, pose_a}, along, radius, options.limit);
  if (!a.is_convex() && b.kind() == ShapeKind::plane)
    return gap_of_mesh_and_plane({a, pose_a}, {b, pose_b}, -along, radius, options.limit);
  const PairAnswer now = unless_stopped(NarrowPhase(options).solve(a, pose_a, b, pose_b, Request::distance));
  return {now.signed_distance, -now.normal.dot(along)};
}

}  // namespace

std::optional<double> NarrowPhase::time_of_impact(const Shape& a, const Pose& pose_a, const Vec3& velocity_a,
                                                  const Shape& b, const Pose& pose_b, const Vec3& velocity_b,
                                                  double tmax) const {
  if (!std::isfinite(tmax) || tmax < 0)
    throw std::invalid_argument("tmax: " + written(tmax) + " is not finite and >= 0");
  if (!velocity_a.allFinite() || !velocity_b.allFinite())
    throw std::invalid_argument("velocity: not finite, every component must be");
  if (const std::string why = refuses(a, b, Request::distance); !why.empty()) throw std::invalid_argument(why);
  if (unless_stopped(solve(a, pose_a, b, pose_b, Request::collide)).collide) return 0.0;
  // Halved, differences stay finite; scaled to one, so do their squares.
  const Vec3 half = velocity_b / 2 - velocity_a / 2;
  const double most = half.cwiseAbs().maxCoeff();
  if (!(most > 0)) return std::nullopt;
  const double length = (half / most).norm();
  const Vec3 along = half / most / length;
  const auto time_of = [&](double advance) { return std::min(tmax, advance / length / most / 2); };
  // Beyond this two bounded shapes have passed each other.
  const Vec3 between = pose_b.translation - pose_a.translation;
  double longest = std::min(2 * length * (most * tmax), 1e290);

  if (!a.is_bounded() || !b.is_bounded()) {
    // The gap to a half-space or plane shrinks at a constant rate.
    const auto [gap, closing] = gap_to_unbounded(a, pose_a, b, pose_b, along, without_cutoff(options_));
    if (gap <= 0) return 0.0;
    if (!(closing > 0)) return std::nullopt;
    const double advance = gap / closing;
    if (!(advance <= longest * (1 + tolerance::end_of_motion))) return std::nullopt;
    return time_of(advance);
  }

  const Body body_a(a, pose_a, options_.limit), body_b(b, pose_b, options_.limit);
  const auto extent = [](const Body& s) { return s.mid.norm() + s.half.norm(); };
  const double passed = 2 * (between.norm() + extent(body_a) + extent(body_b));
  longest = std::min(longest, passed);
  const double radius = a.rounding() + b.rounding();
  const double advance = Sweep(body_a, body_b, between, along, longest, radius, options_.limit).first();
  if (advance == never) return std::nullopt;
  return time_of(advance);
}

}  // namespace tandem
