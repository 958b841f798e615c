// From a patch to contacts: the direction in which depths are measured, the points, and their depths.
#pragma once
#include "meshes/contacts/crossing_patches.h"

namespace tandem {

/// The interval of a ridge inside the other mesh.
struct RidgeSpan {
  Vec3 p, q;
  std::uint32_t feature;
};

/// Appends the intervals of a mesh's ridges inside the other: between two piercings, or from one to an end that is
/// inside. For edges entirely inside their ends suffice.
void find_spans(const PosedMeshes& m, const Patch& patch, std::span<const Crossing> crossings, bool of_a, Memory memory,
                List<RidgeSpan>& spans);

/// The points of a patch, which do not depend on the direction in which depths are measured; of B, of A.
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
  bool sure = false;  ///< the normal of a curve with an area
  Vec3 area;          ///< area vector of the curve
};

/// The direction of the area vector, for a closed curve with an area beyond rounding; else that of the sum of the
/// faces' normals.
PatchNormal normal_of(const PosedMeshes& m, const Patch& patch, const Facets& facets,
                      std::span<const Crossing> crossings);

/// If a body has passed through a flat face beyond its edge, the curve goes around the edge, too: the area vector is
/// slightly off the face's normal, which is the shorter translation. Returns the face's normal, or n if no face is
/// flat.
Vec3 normal_of_face(const PosedMeshes& m, const PatchPoints& points, const Vec3& n);

}  // namespace tandem
