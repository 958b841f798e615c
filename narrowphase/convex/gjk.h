// GJK: the distance of two convex cores, with bounds.
#pragma once
#include <limits>

#include "convex/simplex.h"

namespace tandem {

/// The distance of the cores, until the bounds agree to tolerance x distance. Result `near`: so close to touching that
/// a depth solver must decide.
GjkResult gjk(const MinkowskiDifference& d, double tolerance);

/// `gjk` without the weights of the simplex's points; it also stops as soon as the distance is known to be > beyond or
/// <= within. `start`: a direction from A to B, in A's frame, not zero; null: the one between the centres. `at_once`:
/// ends after the first direction if that does not show two polytopes to be farther apart than this.
GjkResult descend(const MinkowskiDifference& d, double tolerance, double beyond, double within, const Vec3* start,
                  double at_once = -std::numeric_limits<double>::infinity());

/// Sets the points of the answer from its signed distance (of the cores, < 0) and normal: moves B out along the normal,
/// where the nearest points are the pair wanted, whichever faces, edges and corners touch. For curved surfaces it also
/// improves the normal and the distance.
void pair_points(const MinkowskiDifference& d, LocalAnswer& answer);

}  // namespace tandem
