// Faces of a polytope that may be most aligned with a direction.
#pragma once
#include <array>
#include <cstdint>

#include "shapes/face_table.h"

namespace tandem {

/// Bit i: face i may be most aligned with d (unit), by single precision; faces without a bit are not.
using FaceBits = std::array<std::uint64_t, FaceTable::most_faces / 64>;
FaceBits faces_along(const FaceTable& faces, const Vec3& d);

}  // namespace tandem
