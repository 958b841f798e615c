// Patches in a concave corner of one of two meshes, each plane of which pushes.
#pragma once
#include "meshes/contacts/patch_points.h"

namespace tandem {

/// One of several planes that enclose a concave corner.
struct ConcaveCornerFace {
  Vec3 n;  /// unit, from A to B
  double level;
  List<Facet> facets;
};

struct ConcaveCorner {
  explicit ConcaveCorner(Memory memory) : faces(memory) {}
  List<ConcaveCornerFace> faces;  /// none: it is no corner
  bool of_a = false;
};

/// The planes of a mesh's triangles of a patch, where these are few and each lies in front of the others: what has come
/// into such a corner is pushed by each of them. Most patches bend to the other side somewhere, which shows early.
ConcaveCorner find_corner(const PosedMeshes& m, std::span<const Facet> facets, bool of_a, Memory memory);

/// As `add_points` for one of a corner's faces: of its own mesh only what lies in it counts, and what of the other has
/// gone through another face, too, lies over its border there.
void add_corner_face(const PosedMeshes& m, const PatchPoints& points, const ConcaveCorner& corner,
                     const ConcaveCornerFace& face, Memory memory, std::vector<Contact>& contacts);

}  // namespace tandem
