// The contacts of a patch along a given normal.
#pragma once
#include "meshes/contacts/ridge_spans.h"

namespace tandem {

/// Of a patch, what does not depend on the direction along which it is measured; of B, of A.
struct PatchPoints {
  std::array<std::span<const Candidate>, 2> vertices, edges;
  std::array<std::span<const RidgeSpan>, 2> spans;
  Facets facets;
};

/// Appends the contacts of a patch along n.
void add_points(const PosedMeshes& m, const PatchPoints& points, const Vec3& n, Memory memory,
                std::vector<Contact>& contacts);

}  // namespace tandem
