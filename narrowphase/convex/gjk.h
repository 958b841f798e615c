#pragma once
#include <limits>

#include "convex/simplex.h"

namespace tandem {

/// Distance of the cores. Stops as soon as the distance is known to be > beyond or <= within, or the gap is below
/// tolerance x distance. `near`: so close to touching that the depth solver must decide. `start`: a direction from A
/// to B, in A's frame, not zero; without it the one between the centres.
GjkResult gjk(const MinkowskiDifference& d, double tolerance, double beyond, double within,
              const Vec3* start = nullptr);

/// Sets the points of the answer from its signed distance (of the cores, < 0) and normal: B is moved out along the
/// normal, where the nearest points are the pair sought, whichever of its faces, edges and corners touch. On curved
/// surfaces it also improves the normal and the distance.
void pair_points(const MinkowskiDifference& d, LocalAnswer& answer);

/// Signed distance, normal, witness points of two bounded convex shapes: GJK on the cores, and the depth solver
/// where they overlap or nearly do; of polytopes the face on which a portal ends, where that is sure to be the nearest.
/// `tolerance` is relative to the shapes' size, 0: to rounding, as polytopes always are. Ends early for shapes that are
/// more than `beyond` apart: signed_distance is then a separation along the normal, the points are not set.
LocalAnswer gjk_signed_distance(const MinkowskiDifference& d, double tolerance, const Vec3* start = nullptr,
                                double beyond = std::numeric_limits<double>::infinity());

/// Do the shapes touch? Cheaper than the distance. `direction`, where they are apart: one that says so.
bool gjk_collide(const MinkowskiDifference& d, double tolerance, const Vec3* start = nullptr,
                 Vec3* direction = nullptr);

}  // namespace tandem
