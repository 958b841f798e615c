// The last contact of two shapes of which one moves along a direction: the first as it returns from far out.
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "dispatch/swept_body.h"
#include "tandem/narrowphase/clearance.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tolerances.h"

namespace tandem {
namespace {

// The speed along a normal of a body that moves along d (unit); 0 if parallel to the plane, to rounding.
double leaving(const Vec3& normal, const Vec3& d) {
  const double speed = normal.dot(d);
  return std::abs(speed) <= tolerance::parallel_lines ? 0 : speed;
}

// A body that moves along d leaves a plane on the side to which d points: one of its two half-spaces. Parallel to the
// plane it leaves neither.
Shape side_along(const Shape& shape, const Pose& pose, const Vec3& d) {
  if (shape.kind() != ShapeKind::plane) return shape;
  const double speed = leaving(pose.rotation * shape.normal(), d);
  if (speed == 0) return shape;
  const double sense = speed < 0 ? -1 : 1;
  return HalfSpace{sense * shape.normal(), sense * shape.offset() + shape.rounding()};
}

// For a half-space or plane (A or B) and another shape, B moving along d.
double out_of_halfspace(const NarrowPhase& narrow, const Shape& a, const Pose& pose_a, const Shape& b,
                        const Pose& pose_b, const Vec3& d) {
  const PairAnswer now = unless_stopped(narrow.solve(a, pose_a, b, pose_b, Request::distance));
  const double speed = leaving(now.normal, d);
  // If separated, it approaches for ever or never touches; if overlapping, it leaves or never does.
  if (speed < 0) return infinity;
  if (now.signed_distance > 0) return 0;
  return speed > 0 ? -now.signed_distance / speed : infinity;
}

// An upper bound on the translation of B along d (unit) until it is beyond A, by boxes in world axes.
double beyond(const Bounds& a, const Bounds& b, const Vec3& d) {
  const Vec3 far_a = (d.array() > 0).select(a.hi, a.lo), near_b = (d.array() > 0).select(b.lo, b.hi);
  const double size = (a.hi - a.lo).norm() + (b.hi - b.lo).norm();
  return d.dot(far_a - near_b) + tolerance::alike * (size + (far_a - near_b).norm());
}

}  // namespace

double separation_along(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& direction,
                        const NarrowPhaseOptions& options) {
  require_valid(pose_a, "separation_along: pose of A");
  require_valid(pose_b, "separation_along: pose of B");
  const double most = direction.cwiseAbs().maxCoeff();
  if (!direction.allFinite() || !(most > 0))
    throw std::invalid_argument("separation_along: direction, every component must be finite and one not 0");
  const Vec3 d = (direction / most).normalized();
  const NarrowPhase narrow(without_cutoff(options));
  if (const std::string why = narrow.refuses(a, b, Request::distance); !why.empty()) throw std::invalid_argument(why);
  if (!a.is_bounded() || !b.is_bounded())
    return out_of_halfspace(narrow, side_along(a, pose_a, d), pose_a, side_along(b, pose_b, -d), pose_b, d);
  const double far_out = beyond(a.bounds(pose_a), b.bounds(pose_b), d);
  if (!(far_out > 0)) return 0;
  const Pose far{pose_b.rotation, pose_b.translation + far_out * d};
  const auto back = narrow.time_of_impact(a, pose_a, Vec3::Zero(), b, far, -d, far_out);
  return back ? std::max(0.0, far_out - *back) : 0;
}

}  // namespace tandem
