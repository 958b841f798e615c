// The depth of two polytopes where rounding misleads the expanding polytope algorithm.
#pragma once
#include "convex/epa.h"

namespace tandem {

/// The depth of two polytopes by the expanding polytope algorithm in integers: points of the difference are rounded to
/// a grid far finer than their own errors, and of these the polytope is exact. Faces of any width have their normals,
/// and an added point sees the faces that it is beyond and no others. False if the difference has no volume on the
/// grid, or more than some thousand faces are needed. Requires a scale above 0, and the origin in the difference or
/// near it, so that no point is much farther from it than the scale.
bool expand_exactly(const MinkowskiDifference& d, EpaResult& result);

}  // namespace tandem
