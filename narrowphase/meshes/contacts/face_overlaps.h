// Contacts along the normals of flat faces of two meshes that have sunk into each other.
#pragma once
#include <vector>

#include "manifold/patch_collector.h"
#include "meshes/contacts/posed_meshes.h"

namespace tandem {

/// If flat faces of both meshes overlap evenly, these faces push: adds the corners of each
/// overlap of two of them, along their normal. For faces whose edges have passed each other only those with the shorter
/// translation count; in a corner of either mesh all do. `facets` are those of a patch, `area` the area vector of its
/// curve, zero if unknown. False, adding nothing, if there are no such faces, or they are less than half of the patch.
/// `scratch` is unchanged afterwards.
bool add_face_overlaps(const PosedMeshes& m, const Facets& facets, const Vec3& area, Memory memory,
                       PatchCollector& collector, std::vector<Contact>& scratch);

}  // namespace tandem
