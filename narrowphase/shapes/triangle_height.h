// Heights of triangles, exact for slivers.
#pragma once
#include "tandem/narrowphase/pose.h"

namespace tandem {

/// The part of v perpendicular to `along`; v where that is zero.
inline Vec3 perpendicular_part(Vec3 v, const Vec3& along) {
  const double length2 = along.squaredNorm();
  // Two passes: the second removes what rounding left of the first.
  for (int i = 0; i < 2 && length2 > 0; ++i) v -= (v.dot(along) / length2) * along;
  return v;
}

/// A side of a triangle, and the height vector from it to the opposite corner.
struct Height {
  Vec3 side, height;

  Height(const Vec3& along, const Vec3& slant) : side(along), height(perpendicular_part(slant, along)) {}
};

/// The height over the longest side: the rounding error of a sliver's normal, side x height, is then a rotation about
/// that side only, near which its corners are.
inline Height height_of(const Vec3& ab, const Vec3& bc, const Vec3& ca) {
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  if (ab2 >= bc2 && ab2 >= ca2) return {ab, bc};
  return bc2 >= ca2 ? Height(bc, ca) : Height(ca, ab);
}

/// The normal of a triangle by its sides, as long as twice its area: perpendicular to the longest to rounding, so that
/// the plane through a sliver passes its corners within rounding.
inline Vec3 normal_of(const Vec3& ab, const Vec3& bc, const Vec3& ca) {
  const Height over = height_of(ab, bc, ca);
  return over.side.cross(over.height);
}

}  // namespace tandem
