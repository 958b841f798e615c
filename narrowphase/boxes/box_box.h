// The distance of two boxes by separating axes (Gottschalk 1996).
#pragma once
#include "boxes/box_axes.h"
#include "shapes/support.h"

namespace tandem {

/// Collision verdict of two boxes by half sizes, by their 15 axes (Gottschalk 1996), stopping at the first that
/// separates.
bool box_box_collide(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b);

struct BoxAnswer {
  LocalAnswer local;
  int axis = -1;  ///< axis of the normal: 0-2 A's faces, 3-5 B's, 6 + 3 i + j: a_i x b_j; -1: by nearest points
  // For an edge axis, used by the manifold builder:
  double edges_cosine = 0;  ///< cosine of the angle between the two edges, >= 0
  double facing = 0;        ///< the largest cosine of the normal with that of a face
};
/// The signed distance of two boxes. Overlapping: depth and normal are the least over all face and edge axes.
/// Separated: the nearest points, found by exact line searches from the best axis (by GJK where these take too long).
BoxAnswer box_box_distance(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b);
/// The part of the distance query that the manifold builder uses, for boxes whose face axes separate them by no more
/// than the margin; `x`: their axes. Farther apart than the margin, only a separation above it and its axis are set;
/// overlapping with a face's normal, the witness points are left out.
BoxAnswer box_box_overlap(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b,
                          const BoxAxes& x, double margin);

}  // namespace tandem
