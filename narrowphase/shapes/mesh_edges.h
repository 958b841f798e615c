// The neighbours of a mesh's triangles.
#pragma once
#include <cstdint>
#include <vector>

#include "shapes/build_meter.h"
#include "shapes/mesh_frame.h"
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// Sets `closed` of a mesh that has vertices, triangles and frame, and orients a surface's triangles alike. Returns for
/// each vertex its representative: the first of those with equal coordinates, or nearly equal ones on a surface's
/// borders. Throws std::invalid_argument naming the first edge at which a solid is not closed. The same for any number
/// of threads.
std::vector<std::uint32_t> join_triangles(MeshModel& mesh, const PartRunner& parts, BuildMeter& meter);

/// The work of that, in units of the meter, at most.
constexpr std::size_t joining_work(std::size_t triangles) { return triangles; }

/// The neighbours of all triangles, for a mesh processed by join_triangles. Throws WorkStopped if the limit is reached.
MeshModel::Neighbours find_neighbours(const MeshModel& mesh, const WorkLimit* limit);

}  // namespace tandem
