// The distance up to which rounding may decide a verdict.
#pragma once
#include "tandem/narrowphase/shape.h"
#include "tolerances.h"

namespace tandem {

/// Up to this distance (metres, of either sign) rounding may decide whether a solver finds contact: the verdict of
/// Request::collide then holds for all requests.
inline double undecided_distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  return tolerance::undecided * (a.size() + b.size() + (pose_b.translation - pose_a.translation).lpNorm<1>());
}

}  // namespace tandem
