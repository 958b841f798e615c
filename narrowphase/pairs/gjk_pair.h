// Two bounded convex shapes by GJK: which methods, in which order, and when an answer is good enough.
#pragma once
#include <limits>

#include "shapes/minkowski_difference.h"

namespace tandem {

/// Signed distance, normal and witness points of two bounded convex shapes: GJK on the cores, and a depth solver where
/// they overlap or nearly do; for polytopes the face on which a portal ends, where that is certainly the nearest.
/// `tolerance` is relative to the shapes' size, 0: to rounding, as always for polytopes. Ends early for shapes more
/// than `beyond` apart: signed_distance is then a separation along the normal, the points are not set.
LocalAnswer gjk_signed_distance(const MinkowskiDifference& d, double tolerance, const Vec3* start = nullptr,
                                double beyond = std::numeric_limits<double>::infinity());

/// True if the shapes touch. Cheaper than the distance. `direction`: a separating one, if they are apart.
bool gjk_collide(const MinkowskiDifference& d, double tolerance, const Vec3* start = nullptr,
                 Vec3* direction = nullptr);

}  // namespace tandem
