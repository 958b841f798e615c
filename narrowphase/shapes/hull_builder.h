#pragma once
#include <span>

#include "shapes/hull.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem {

/// Hull of one or more finite points, through Qhull. Every point lies within 1e-12 of the cloud's size of it.
/// Reentrant; prints nothing. Throws std::invalid_argument if `points` is empty, WorkStopped where the limit ended it.
Hull build_hull(std::span<const Vec3> points, const WorkLimit* limit = nullptr);

}  // namespace tandem
