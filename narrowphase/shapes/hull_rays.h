#pragma once
#include "shapes/hull.h"

namespace tandem {

/// The table of a hull of dimension 3 with faces; empty where corners have too high numbers.
RayMap map_rays(const Hull& hull);

}  // namespace tandem
