// Contact manifolds of two boxes, and of a half-space and a box.
#pragma once
#include <vector>

#include "boxes/box_box.h"
#include "manifold/rectangle_clip.h"
#include "tandem/narrowphase/answer.h"

namespace tandem {

/// Appends the contact points of two boxes (half sizes) whose normal is a face's or near one (`carries_patch`): the
/// incident face's rectangle clipped by the reference face's. `answer.axis` >= 0. Points are named by the corners and
/// edges that meet. Appends nothing if the patch misses the deepest point of an edge axis.
void append_box_manifold(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b,
                         const BoxAnswer& answer, double margin, std::vector<Contact>& contacts);

/// The last stage of the above after `clip_rectangles`: `column` of the patches, `pair` of its input. The normal is in
/// the world, from A to B; `tilted`: it is an edge axis, and not a face normal too.
void append_box_patch(const RectanglePairRows& pairs, std::size_t pair, const RectanglePatchRows& patches,
                      std::size_t column, bool tilted, const HalfSize& a, const Pose& pose_a, const HalfSize& b,
                      const Pose& pose_b, const Vec3& normal, std::vector<Contact>& contacts);

/// Appends the contact points of a half-space and a box within the margin, by its half sizes. `slope`: the half-space's
/// normal in the box's frame; `height`: of the box's centre above the plane.
void append_halfspace_box(const HalfSize& half, const Pose& pose, const Vec3& world_normal, const Vec3& slope,
                          double height, double margin, std::vector<Contact>& contacts);

}  // namespace tandem
