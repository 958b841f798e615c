#pragma once
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Up to this distance (metres, of either sign) rounding may decide what a solver takes for a touch: then the verdict
/// of Request::collide is that of all requests. Relative to the sizes and the translation between them, some 500
/// epsilon: the solvers are right to a tenth of it.
inline double undecided_distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  constexpr double decided_by_rounding = 1e-13;
  return decided_by_rounding * (a.size() + b.size() + (pose_b.translation - pose_a.translation).lpNorm<1>());
}

}  // namespace tandem
