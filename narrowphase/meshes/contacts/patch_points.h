// From a patch to contacts: the direction along which it is measured, its points, and how deep these lie.
#pragma once
#include "meshes/contacts/crossing_patches.h"

namespace tandem {

/// The stretch of a ridge inside the other mesh.
struct RidgeSpan {
  Vec3 p, q;
  std::uint32_t feature;
};

/// Appends what of the ridges of a mesh lies inside the other: between two piercings, or from one to an end that is
/// inside. Of those that lie inside as a whole the ends say enough.
void find_spans(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings, bool of_a, Memory memory,
                List<RidgeSpan>& spans);

/// What of a patch does not depend on the direction along which it is measured; of B, of A.
struct PatchPoints {
  std::array<std::span<const Candidate>, 2> vertices, edges;
  std::array<std::span<const RidgeSpan>, 2> spans;
  Facets facets;
};

/// Appends the contacts of a patch along n.
void add_points(const PosedMeshes& m, const PatchPoints& points, const Vec3& n, Memory memory,
                std::vector<Contact>& contacts);

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
