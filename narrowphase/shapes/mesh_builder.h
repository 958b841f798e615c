// From a mesh as given to what queries need: checked, with its hull, its triangles joined at their edges, its hierarchy.
#pragma once
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// Throws std::invalid_argument naming the mesh's first fault: no triangles, a vertex that is not finite, an index
/// out of range, or for a solid mesh an edge that does not join triangles in opposite sense.
/// `parts` (may be empty: the caller) shares the work; the model does not depend on it.
MeshModel build_mesh(Mesh mesh, const PartRunner& parts = {});

/// The first of the vertices with the same coordinates, for each vertex. Files often repeat vertices.
std::vector<std::uint32_t> weld(const std::vector<Vec3>& vertices);

}  // namespace tandem
