// Contact manifolds of two shapes: the features that carry the patch, and the points that are kept.
#pragma once
#include <vector>

#include "closed_forms/closed_forms.h"
#include "manifold/patch_point.h"
#include "tandem/narrowphase/answer.h"

namespace tandem {

/// Appends the contact points of two bounded convex shapes whose signed distance and normal are known: the face of one
/// clipped by the face of the other, or the common interval of two parallel edges, or one point; at most 4 that span
/// the patch, each with its own depth along the common normal, at least -margin. In world coordinates, sorted by
/// feature. `whole`: all points of the patch, not only those that span it.
void append_manifold(const ConvexView& a, const ConvexView& b, const RelativePose& relative, const LocalAnswer& answer,
                     double margin, const Pose& pose_a, std::vector<Contact>& contacts, bool whole = false);

/// Appends the two ends of the interval where capsules with parallel axes lie side by side; false, appending nothing,
/// where they do not. Neither is farther apart than the margin. `axes` is the distance of their axes relative to A's
/// centre, in world directions. A comes first by content.
bool append_parallel_capsules(const SegmentDistance& axes, double radius_a, double length_a, const Pose& pose_a,
                              double radius_b, double length_b, const Pose& pose_b, double margin,
                              std::vector<Contact>& contacts);

/// Appends the contact points of a convex shape and a half-space, whose (unit) normal and offset are given in the
/// shape's frame; the contact normals are the half-space's.
void append_halfspace_manifold(const ConvexView& shape, const Pose& pose, const Vec3& normal, double offset,
                               double margin, std::vector<Contact>& contacts);

/// If points of clipped faces include the pair's deepest point, `depth` deep, to rounding, the deepest of them gets
/// that depth. False if not: circles are clipped as polygons, and a slanting face may not contain that point, which
/// the caller then adds.
bool set_deepest(PatchPoint* points, int count, double depth, double slack);

/// Gives the greatest depth to the first of the points whose depth is equal to it within `slack`, as `span_patch` does.
void share_greatest_depth(PatchPoint* points, int count, double slack);

/// Keeps up to 4 of the points, in the order of their features: the deepest, the farthest from it, then those that
/// widen the patch most to either side; among equals the first by feature. A disc's `lowest` is preferred among equally
/// deep points. Returns how many.
int span_patch(PatchPoint* points, int count, const Vec3& normal, double size);

/// Appends the points as contacts; `normal` in world coordinates.
void append_points(const PatchPoint* points, int count, const Pose& pose, const Vec3& normal,
                   std::vector<Contact>& contacts);

/// Appends the answer's witness points as the one contact, if they are no farther apart than the margin; nothing for
/// null.
inline void append_single(const PairAnswer& answer, double margin, std::vector<Contact>* contacts) {
  if (contacts != nullptr && answer.signed_distance <= margin)
    contacts->push_back({0.5 * (answer.point_a + answer.point_b), answer.normal, -answer.signed_distance, 0});
}

}  // namespace tandem
