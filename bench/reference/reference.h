// A certified reference for signed distances, independent of the library's solvers.
#pragma once
#include "tandem/narrowphase/shape.h"

namespace tandem::reference {

/// The signed distance of two posed convex shapes, to judge solvers by: for the real numbers R v + t, in 113-bit
/// arithmetic, independent of the solvers.
struct Truth {
  double signed_distance;  ///< > 0 distance, < 0 minus the depth; attained along `normal`
  double error;            ///< certified: |true - signed_distance| <= error
  Vec3 normal;             ///< unit, from A to B
  bool normal_unique;      ///< no other normal comes within 1e-9 of the size
};

/// The signed distance of every pair of convex kinds but two half-spaces; poses must be valid. Where round shapes
/// overlap and many directions are nearly as good, the error may stay large: signed_distance is then still a lower
/// bound, and the best of all directions tried.
Truth signed_distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b);

/// The separation along a direction from A to B (not zero), a lower bound of the signed distance for any direction.
/// From a half-space only its own normal (within 2e-15) separates: minus infinity along any other.
double separation(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& direction);

}  // namespace tandem::reference
