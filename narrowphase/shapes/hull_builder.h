// Builds convex hulls by Qhull.
#pragma once
#include <span>

#include "shapes/hull.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// The hull of one or more finite points. Every point lies within 1e-12 of the points' extent of it. Reentrant; prints
/// nothing. Throws std::invalid_argument if `points` is empty, WorkStopped if the limit ended it.
Hull build_hull(std::span<const Vec3> points, const WorkLimit* limit = nullptr);

}  // namespace tandem
