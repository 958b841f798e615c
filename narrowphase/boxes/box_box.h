#pragma once
#include "boxes/box_axes.h"
#include "shapes/support.h"

namespace tandem {

/// Two boxes by half sizes: the verdict by their 15 axes (Gottschalk 1996), which leaves where one separates.
bool box_box_collide(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b);

struct BoxAnswer {
  LocalAnswer local;
  int axis = -1;  ///< of the normal: 0-2 A's faces, 3-5 B's, 6 + 3 i + j: a_i x b_j; -1: none, nearest points
  // Of an edges' axis, for the manifold:
  double edges_cosine = 0;  ///< of the two edges' directions, >= 0
  double facing = 0;        ///< the largest cosine of the normal with that of a face
};
/// Signed distance of two boxes: overlapping, depth and normal are the least over all axes, faces and edges alike;
/// apart, the nearest points, found by exact line searches from the best axis (by GJK where these take too long).
BoxAnswer box_box_distance(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b);
/// What a manifold needs of it, of two whose faces part them by no more than the margin, by their axes: farther apart
/// than the margin, only a separation above it and its axis; overlapping with the normal of a face, the witness points
/// are left out.
BoxAnswer box_box_overlap(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b,
                          const BoxAxes& x, double margin);

}  // namespace tandem
