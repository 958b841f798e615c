// The distance of a point from a shape's surface, by formulas that share nothing with the solvers.
#pragma once
#include "posed_pair.h"

namespace tandem::relations {

/// Metres, >= 0; `made`: the Shape made of `shape`. Ellipsoids: to first order in the distance; hulls and meshes: by
/// the narrow phase's distance of a point.
double surface_distance(const PosedShape& shape, const Shape& made, const Vec3& world);

}  // namespace tandem::relations
