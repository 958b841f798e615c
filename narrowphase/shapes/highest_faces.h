// The faces of a small polytope that may be the highest over a point, or the most aligned with a direction.
#pragma once
#include <array>
#include <bit>
#include <cstdint>

#include "shapes/hull.h"

namespace tandem {

/// Bit i: face i may be the highest, by single precision; faces without a bit are not.
using FaceBits = std::array<std::uint64_t, FaceTable::most_faces / 64>;

/// The faces with the highest normal . d; d: unit.
FaceBits faces_along(const FaceTable& faces, const Vec3& d);

/// The faces with the greatest signed distance normal . p - offset, for a hull with a face table. p: in the hull's
/// frame, metres.
FaceBits faces_over(const Hull& hull, const Vec3& p);

/// Calls use(i) for each face with a bit, from the least i on.
template <class Use>
void for_each_face(const FaceBits& bits, const Use& use) {
  for (std::size_t k = 0; k < bits.size(); ++k)
    for (std::uint64_t left = bits[k]; left != 0; left &= left - 1)
      use(64 * k + static_cast<std::size_t>(std::countr_zero(left)));
}

}  // namespace tandem
