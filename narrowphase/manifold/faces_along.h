#pragma once
#include <array>
#include <cstdint>

#include "shapes/face_table.h"

namespace tandem {

/// Bit i: face i may be the one that looks most along d (unit), by single precision; of no other can it be true.
using FaceBits = std::array<std::uint64_t, FaceTable::most_faces / 64>;
FaceBits faces_along(const FaceTable& faces, const Vec3& d);

}  // namespace tandem
