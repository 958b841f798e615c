// How far a point lies from a shape's surface, by formulas that share nothing with the solvers.
#pragma once
#include "posed_pair.h"

namespace tandem::relations {

/// Metres, >= 0; `made`: of `shape`. Of ellipsoids to first order in the distance; hulls and meshes ask the narrow
/// phase for the distance of a point.
double surface_distance(const PosedShape& shape, const Shape& made, const Vec3& world);

}  // namespace tandem::relations
