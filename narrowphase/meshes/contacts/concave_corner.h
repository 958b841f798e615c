// Patches in a concave corner of one of two meshes, of which every face pushes.
#pragma once
#include "meshes/contacts/patch_points.h"

namespace tandem {

/// One of several planes that form a concave corner.
struct ConcaveCornerFace {
  Vec3 n;  /// unit, from A to B
  double level;
  List<Facet> facets;
};

struct ConcaveCorner {
  explicit ConcaveCorner(Memory memory) : faces(memory) {}
  List<ConcaveCornerFace> faces;  /// empty: not a corner
  bool of_a = false;
};

/// The planes of a mesh's triangles of a patch, if these are few and each lies in front of the others: a body in such a
/// corner is pushed by each of them. Most patches are convex somewhere, which is found early.
ConcaveCorner find_corner(const PosedMeshes& m, std::span<const Facet> facets, bool of_a, Memory memory);

/// As `add_points` for one of a corner's faces: of its own mesh only the points in the face count, and points of the
/// other mesh that are also behind another face lie beyond the face's border.
void add_corner_face(const PosedMeshes& m, const PatchPoints& points, const ConcaveCorner& corner,
                     const ConcaveCornerFace& face, Memory memory, std::vector<Contact>& contacts);

}  // namespace tandem
