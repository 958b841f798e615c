#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// All pairs of triangles [i of A, j of B] that meet, sorted; each shape a mesh or a triangle. Exact.
std::vector<std::array<std::uint32_t, 2>> mesh_triangle_pairs(const Shape& a, const Pose& pose_a, const Shape& b,
                                                              const Pose& pose_b);

}  // namespace tandem
