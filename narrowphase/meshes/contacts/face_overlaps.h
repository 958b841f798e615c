// Flat faces of two meshes that have sunk into each other, and the contacts along their normals.
#pragma once
#include <vector>

#include "manifold/patch_collector.h"
#include "meshes/contacts/posed_meshes.h"

namespace tandem {

/// Where flat faces of both meshes have sunk into each other, as thick all over, it is these that push: adds the
/// corners of what each two of them share, along their normal. Of two whose edges have gone past each other only those
/// count whose translation is shorter; in a corner of either mesh all. `facets` are those of a patch, `area` the area
/// vector of its curve, zero where that is not known. False, and nothing: there are no such faces, or they are less
/// than half of the patch. What `scratch` holds stays as it is.
bool add_face_overlaps(const PosedMeshes& m, const Facets& facets, const Vec3& area, Memory memory,
                       PatchCollector& collector, std::vector<Contact>& scratch);

}  // namespace tandem
