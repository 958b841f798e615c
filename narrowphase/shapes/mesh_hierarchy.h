// The hierarchy of boxes over a mesh's triangles.
#pragma once
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// Fills nodes, blocks, slabs, order and depth of a mesh that has vertices, triangles, centre, half and unit. The same on
/// any number of threads; `parts` (may be empty: the caller) shares the subtrees.
void build_hierarchy(MeshModel& mesh, const PartRunner& parts);

}  // namespace tandem
