// Queries of a pair with default options.
#pragma once
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

inline bool collide(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  return NarrowPhase().solve(a, pose_a, b, pose_b, Request::collide).collide;
}

inline Pose moved(const Pose& pose, const Vec3& by) { return {pose.rotation, pose.translation + by}; }

}  // namespace tandem
