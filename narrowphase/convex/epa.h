#pragma once
#include "convex/simplex.h"

namespace tandem {

struct EpaResult {
  Vec3 normal = Vec3::UnitX();  ///< unit, outward of A - B: from A to B
  double upper = 0;  ///< the depth of the cores is at most this (negative: they are apart by at least minus this)
  double lower = 0;  ///< and at least this, while they overlap
  Vec3 point_a = Vec3::Zero();  ///< of A, and of B: upper * normal apart only where the chosen face holds the
  Vec3 point_b = Vec3::Zero();  ///< origin's projection (of coplanar faces, another one may)
};

/// Is the simplex a tetrahedron that is not thin? Then `expand` begins with it and asks for no weights.
bool is_solid(const MinkowskiDifference& d, const Simplex& s);

/// Expanding polytope (van den Bergen 2001) from the simplex where GJK stopped, in or near the origin. Offsets of
/// faces are signed, so an origin a rounding error outside is as good as one inside. Flat and pointlike differences
/// have depth 0. Bounded work; stops when upper - lower <= tolerance. Allocates only beyond 128 vertices.
EpaResult expand(const MinkowskiDifference& d, const Simplex& start, double tolerance);

/// The depth to rounding of two polytopes that overlap by balls inside both: from supports all around, which wait for
/// nothing but memory, side by side. Cheaper than from GJK's simplex where many vertices are needed.
EpaResult expand_all_around(const MinkowskiDifference& d);

}  // namespace tandem
