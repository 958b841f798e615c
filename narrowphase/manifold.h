#pragma once
#include <vector>

#include "support.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// Contact points of two bounded convex shapes whose signed distance and normal are known: the face of one clipped
/// by the face it lies on, or the stretch of two parallel edges, or one point; at most 4 that span the patch, each
/// with its own depth along the common normal, at least -margin. Appended in world coordinates, by feature.
void append_manifold(const ConvexView& a, const ConvexView& b, const RelativePose& relative, const LocalAnswer& answer,
                     double margin, const Pose& pose_a, std::vector<Contact>& contacts);

/// The same for a half-space with (unit) normal and offset given in the shape's frame; the contact normals are
/// the half-space's.
void append_halfspace_manifold(const ConvexView& shape, const Pose& pose, const Vec3& normal, double offset,
                               double margin, std::vector<Contact>& contacts);

}  // namespace tandem
