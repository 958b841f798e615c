#pragma once
#include "tandem/narrowphase/pose.h"

namespace tandem {

/// A side of a triangle, and what is square to it of the vector from it to the opposite corner.
struct Height {
  Vec3 side, height;

  Height(const Vec3& along, const Vec3& slant) : side(along), height(slant) {
    const double length2 = along.squaredNorm();
    // Twice: the second takes what the first left by rounding.
    for (int i = 0; i < 2 && length2 > 0; ++i) height -= (height.dot(side) / length2) * side;
  }
};
/// Over the longest side: a sliver's normal, side x height, is rounded about that side only, where its corners are
/// near.
inline Height height_of(const Vec3& ab, const Vec3& bc, const Vec3& ca) {
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  if (ab2 >= bc2 && ab2 >= ca2) return {ab, bc};
  return bc2 >= ca2 ? Height(bc, ca) : Height(ca, ab);
}
}  // namespace tandem
