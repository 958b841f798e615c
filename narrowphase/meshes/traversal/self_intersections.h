#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "shapes/mesh_model.h"
#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/search.h"

namespace tandem {

/// All pairs of triangles i < j of a mesh that meet, exactly, and share no vertex, sorted. `first`: of each vertex the
/// one that stands for it.
std::vector<std::array<std::uint32_t, 2>> self_intersections(const MeshModel& mesh,
                                                             std::span<const std::uint32_t> first,
                                                             const PartRunner& parts);

/// Tells a mesh's crossings with itself one after the other until `visitor` returns false.
SearchEnd visit_self_intersections(const MeshModel& mesh, std::span<const std::uint32_t> first,
                                   const std::function<bool(const std::array<std::uint32_t, 2>&)>& visitor,
                                   const SearchOptions& options);

}  // namespace tandem
