// Which of a mesh's triangles lie side by side.
#pragma once
#include <cstdint>
#include <vector>

#include "shapes/build_meter.h"
#include "shapes/mesh_frame.h"
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// Fills closed of a mesh that has vertices and triangles, and turns a surface's triangles alike.
/// Answers for each vertex the one that stands for it: the first of those with equal coordinates, or nearly so on a
/// surface's borders. Throws std::invalid_argument naming the first edge at which a solid is not closed. The same on
/// any number of threads.
std::vector<std::uint32_t> join_triangles(MeshModel& mesh, const MeshFrame& frame, const PartRunner& parts,
                                          BuildMeter& meter);

/// What that spends of a meter, at most.
constexpr std::size_t joining_work(std::size_t triangles) { return triangles; }

/// Which triangles lie side by side, of a mesh that has been through that. Throws WorkStopped where the limit is
/// reached.
MeshModel::Neighbours find_neighbours(const MeshModel& mesh, const WorkLimit* limit);

}  // namespace tandem
