// Pairs at rest, as the steps of a simulation leave them.
#pragma once
#include "posed_pair.h"

namespace tandem::relations {

/// Moves B against A until it touches, and along what it touches until it touches at up to three places, then into some
/// of these by up to 3e-3 of its size, or by nothing. A is often replaced by a solid with corners: cubes of a grid, a
/// height field, a room, a torus, voxels. The pair stays as it is if B overlaps A where it starts. Where B ends is
/// computed by `NarrowPhase`, so that a seed may give other pairs with other versions.
void settle(PosedPair& pair, Random& r);

}  // namespace tandem::relations
