// Pairs that users have and that shapes and poses drawn apart from each other seldom or never are.
#pragma once
#include "posed_pair.h"

namespace tandem::relations {

/// Makes of a drawn pair one of: triangles given twice, a hull of up to 3,000 points, boxes in a stack, a solid within
/// its like, thin walls, shapes far from their own origin, a shape twice at (nearly) one place, an exact place turned,
/// cubes of a grid and land.
void make_unusual(PosedPair& pair, Random& r);

}  // namespace tandem::relations
