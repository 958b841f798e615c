// Pairs that occur in use, but seldom or never when shapes and poses are drawn independently.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "posed_pair.h"

namespace tandem::relations {

/// Changes a drawn pair into one of: repeated triangles, a hull of up to 3,000 points, boxes in a stack, a solid inside
/// a similar one, thin walls, shapes far from their own origin, a shape twice at (nearly) one place, an exact pose
/// rotated, cubes of a grid and height fields.
void make_unusual(PosedPair& pair, Random& r);

/// Places of a grid near its origin, some of them twice.
std::vector<std::array<std::int32_t, 3>> grid_places(int count, Random& r);
/// Cubes of a grid near each other.
Mesh cubes(double size, Random& r);
/// A height field, steep or flat to 1e-12, its heights multiples of an eighth or arbitrary.
Mesh land(double size, Random& r);

}  // namespace tandem::relations
