// Pairs with a cylinder, cone or ellipsoid.
#pragma once
#include "shapes/minkowski_difference.h"

namespace tandem {

/// Signed distance, normal and witness points of a cylinder, cone or ellipsoid and another bounded convex shape:
/// Newton's method on the support functions, to rounding. `start` and `beyond` as for gjk_signed_distance.
LocalAnswer round_signed_distance(const MinkowskiDifference& d, const Vec3* start = nullptr,
                                  double beyond = std::numeric_limits<double>::infinity());

/// True if they touch. Cheaper than the distance.
bool round_collide(const MinkowskiDifference& d);

}  // namespace tandem
