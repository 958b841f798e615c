#pragma once
#include <vector>

#include "boxes/box_box.h"
#include "manifold/rectangle_clip.h"
#include "tandem/narrowphase/answer.h"

namespace tandem {

/// Contact points of two boxes (half sizes) whose normal is a face's (or lies near one, `carries_patch`): the incident
/// face's rectangle clipped by the reference face's, in the plane. `answer.axis` >= 0. Points are named by the corners
/// and edges that meet. Nothing is appended where the patch misses the deepest point of an edges' axis.
void append_box_manifold(const HalfSize& a, const Pose& pose_a, const HalfSize& b, const Pose& pose_b,
                         const BoxAnswer& answer, double margin, std::vector<Contact>& contacts);

/// The end of it where `clip_rectangles` has found the patch: `column` of the patches, `pair` of what was clipped. The
/// normal is in the world, from A to B; `tilted`: of an edges' axis, and not a face's too.
void append_box_patch(const RectanglePairRows& pairs, std::size_t pair, const RectanglePatchRows& patches,
                      std::size_t column, bool tilted, const HalfSize& a, const Pose& pose_a, const HalfSize& b,
                      const Pose& pose_b, const Vec3& normal, std::vector<Contact>& contacts);

/// Contact points of a half-space and a box that is no farther away than the margin, by its half sizes: `slope` is the
/// half-space's (world) normal in the box's frame, `height` that of the box's centre above it.
void append_halfspace_box(const HalfSize& half, const Pose& pose, const Vec3& world_normal, const Vec3& slope,
                          double height, double margin, std::vector<Contact>& contacts);

}  // namespace tandem
