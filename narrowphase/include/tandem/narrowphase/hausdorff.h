// The Hausdorff distance of two surfaces, with bounds.
#pragma once
#include <cstddef>

#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Accuracy and limits of the search for a Hausdorff distance.
struct HausdorffOptions {
  /// The search ends when the bounds differ by at most this (metres, finite, >= 0) ...
  double tolerance = 0;
  /// ... or by this fraction of the upper one, [0, 1] ...
  double gap = 1e-3;
  /// ... or when the upper one is at most this fraction of the surfaces' size (the sum of half the diagonals of their
  /// boxes), [0, 1]: for the same surface triangulated in two ways the distance is 0, and no bound is within a fraction
  /// of it. All three 0: to rounding, or until `most_parts`.
  double least = 1e-4;
  /// The most boxes and pieces of triangles that are examined; each may be held, in some 100 bytes.
  std::size_t most_parts = 1'000'000;
  /// Ends the search (work_limit.h): WorkStopped is thrown. Null: none.
  const WorkLimit* limit = nullptr;
};

/// Bounds on the Hausdorff distance of two surfaces: the largest distance from a point of either to the other.
struct HausdorffBounds {
  double lower = 0, upper = 0;  ///< metres
  /// A point of A's surface if `of_a`, else of B's, at distance `lower` from the other surface, and the nearest point
  /// of that; world.
  Vec3 point = Vec3::Zero(), nearest = Vec3::Zero();
  bool of_a = true;
  std::size_t parts = 0;  ///< boxes and pieces that were examined
};

/// Bounds the Hausdorff distance of the surfaces of two meshes (or triangles), solid or not; insides do not count. By
/// branch and bound over the boxes and triangles of both: of a part no point is farther away than its middle and half
/// its size together, nor than the farthest of its corners from any one triangle, a convex set (Tang, Lee and Kim,
/// Interactive Hausdorff distance computation for general polygonal models, 2009). Depends on nothing but the
/// arguments; exchanged shapes give the same bounds. Throws std::invalid_argument for another kind of shape, one with
/// rounding, a bad pose or option.
HausdorffBounds hausdorff_distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                   const HausdorffOptions& options = {});

}  // namespace tandem
