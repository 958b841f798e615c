// The direction along which a patch of two meshes is measured.
#pragma once
#include "meshes/contacts/patch_points.h"

namespace tandem {

struct PatchNormal {
  Vec3 n;             ///< unit, from A to B; zero if there is none
  bool sure = false;  ///< of a curve with an area
  Vec3 area;          ///< of the curve
};

/// The area vector's direction, of a curve that closes and has an area beyond rounding; else that of the faces' sum.
PatchNormal normal_of(const PosedMeshes& m, const Patch& patch, const Facets& facets,
                      std::span<const Crossing> crossings);

/// The curve of what has come through a flat face goes round the face's edge, too, where it lies over that: a little
/// off the face's normal, which is the shorter translation. Returns that, or n where no face is flat.
Vec3 normal_of_face(const PosedMeshes& m, const PatchPoints& points, const Vec3& n);

}  // namespace tandem
