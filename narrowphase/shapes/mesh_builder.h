// From a mesh as given to what queries need: checked, its triangles joined at their edges, its hierarchy.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "shapes/mesh_frame.h"
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/build_options.h"
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// Throws std::invalid_argument naming the mesh's first fault: no triangles, a vertex that is not finite, an index
/// out of range, or for a solid mesh an edge that does not join triangles in opposite sense.
/// WorkStopped where the options' limit was reached. The model does not depend on the options. `first`, if not null,
/// gets for each vertex the one that stands for it: the first of those with equal coordinates, or nearly so on a
/// surface's borders.
MeshModel build_mesh(Mesh mesh, const BuildOptions& options = {}, std::vector<std::uint32_t>* first = nullptr);

/// Whether a triangle has a vertex, of each.
std::vector<std::uint8_t> vertices_in_use(const MeshModel& mesh);

/// The volume of the closed mesh with these vertices, where that is less than none: it is inside out.
std::optional<double> inside_out(const MeshModel& mesh, std::span<const Vec3> vertices, const MeshFrame& frame,
                                 const PartRunner& parts = {});

}  // namespace tandem
