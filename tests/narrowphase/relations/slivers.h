// Pairs of a sliver and a shape set on its face.
#pragma once
#include "posed_pair.h"

namespace tandem::relations {

/// Replaces A by a triangle 1 long and 1e-12 to 1 high: as triangle, as hull, as blade (a tetrahedron hardly thicker)
/// or as mesh. B, 1e-8 to 1 long and often thin, is set on a point of it, often near a side or corner: touching, 1e-18
/// to 0.1 beside it or as deep in it; often B's axis is nearly the normal of the sliver, or nearly in its plane. A
/// half-space or plane as B stays where it was drawn.
void set_on_sliver(PosedPair& pair, Random& r);

}  // namespace tandem::relations
