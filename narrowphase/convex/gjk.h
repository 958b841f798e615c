#pragma once
#include <limits>

#include "convex/simplex.h"

namespace tandem {

/// Distance of the cores. Stops as soon as the distance is known to be > beyond or <= within, or the gap is below
/// tolerance x distance. `near`: so close to touching that the depth solver must decide. `start`: a direction from A
/// to B, in A's frame, not zero; without it the one between the centres.
GjkResult gjk(const MinkowskiDifference& d, double tolerance, double beyond, double within,
              const Vec3* start = nullptr);

/// `gjk` without the weights of the simplex's points. `at_once`: where the first direction does not show two
/// polytopes to be farther apart than this, it stops there.
GjkResult descend(const MinkowskiDifference& d, double tolerance, double beyond, double within, const Vec3* start,
                  double at_once = -std::numeric_limits<double>::infinity());

/// Sets the points of the answer from its signed distance (of the cores, < 0) and normal: B is moved out along the
/// normal, where the nearest points are the pair sought, whichever of its faces, edges and corners touch. On curved
/// surfaces it also improves the normal and the distance.
void pair_points(const MinkowskiDifference& d, LocalAnswer& answer);

}  // namespace tandem
