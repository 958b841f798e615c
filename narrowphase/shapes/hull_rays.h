// The table of faces through which rays from the interior of a hull leave.
#pragma once
#include "shapes/hull.h"

namespace tandem {

/// Builds the table for a hull of dimension 3 with faces; empty if vertex numbers are too large.
RayMap map_rays(const Hull& hull);

}  // namespace tandem
