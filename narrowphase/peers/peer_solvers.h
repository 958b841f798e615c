// FCL and libccd as solvers of two convex shapes.
#pragma once
#include <optional>

#include "shapes/support.h"

namespace tandem {

/// Empty if the method cannot answer the request for this pair (gjk then does), or failed.
std::optional<bool> fcl_collide(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b);
std::optional<LocalAnswer> fcl_signed_distance(const ConvexView& a, const ConvexView& b, const RelativePose& pose);
std::optional<bool> ccd_collide(const ConvexView& a, const ConvexView& b, const RelativePose& pose, bool portal);
std::optional<LocalAnswer> ccd_depth(const ConvexView& a, const ConvexView& b, const RelativePose& pose, bool portal);

}  // namespace tandem
