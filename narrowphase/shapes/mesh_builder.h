// Builds a mesh's model from the given mesh: checked, with neighbours and hierarchy.
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

/// Throws std::invalid_argument naming the mesh's first fault: no triangles, a vertex that is not finite, an index out
/// of range, or for a solid mesh an edge that does not join triangles of opposite direction. Throws WorkStopped if the
/// options' limit was reached. The model does not depend on the options. `first`, if not null, gets for each vertex its
/// representative: the first of those with equal coordinates, or nearly equal ones on a surface's borders.
MeshModel build_mesh(Mesh mesh, const BuildOptions& options = {}, std::vector<std::uint32_t>* first = nullptr);

/// For each vertex whether a triangle uses it.
std::vector<std::uint8_t> vertices_in_use(const MeshModel& mesh);

/// The volume of the closed mesh with these vertices, of which it has the frame, if it is negative: the mesh is inside
/// out.
std::optional<double> inside_out(const MeshModel& mesh, std::span<const Vec3> vertices, const PartRunner& parts = {});

}  // namespace tandem
