// The expanding polytope algorithm, for the depth of overlapping cores.
#pragma once
#include "convex/simplex.h"

namespace tandem {

struct EpaResult {
  Vec3 normal = Vec3::UnitX();  ///< unit, outward of A - B: from A to B
  double upper = 0;  ///< upper bound on the depth of the cores (negative: they are separated by at least minus this)
  double lower = 0;  ///< lower bound on the depth, if they overlap
  Vec3 point_a = Vec3::Zero();  ///< on A and on B: apart by upper * normal only where the chosen face contains
  Vec3 point_b = Vec3::Zero();  ///< the origin's projection (of coplanar faces, another one may)
};

namespace epa {
/// The cost of adding a point, in units of the work meter, and of the work until the limit is first checked: few
/// searches need more points.
inline constexpr int a_point = 16, a_hundred_points = 100 * a_point;
}  // namespace epa

/// Sets the points of a result whose upper bound and normal are known: by the weights of the origin's projection on the
/// face with these corners, clamped to it.
void set_points(const MinkowskiPoint& a, const MinkowskiPoint& b, const MinkowskiPoint& c, EpaResult& r);

/// The expanding polytope algorithm (van den Bergen 2001) from the simplex where GJK stopped, in or near the origin.
/// Offsets of faces are signed, so an origin outside by a rounding error does no harm. Flat and pointlike differences
/// have depth 0. Bounded work; stops when upper - lower <= tolerance. Allocates only beyond 128 vertices.
EpaResult expand(const MinkowskiDifference& d, const Simplex& start, double tolerance);

/// The depth, to rounding, of two polytopes whose inscribed balls overlap: begins with supports in directions all
/// around, which are independent of each other. Cheaper than starting with GJK's simplex where many vertices are
/// needed.
EpaResult expand_all_around(const MinkowskiDifference& d);

}  // namespace tandem
