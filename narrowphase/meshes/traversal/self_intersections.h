// Self-intersections of a mesh, exactly.
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

/// All pairs of triangles i < j of a mesh that intersect, exactly, and share no vertex, sorted. `first`: the
/// representative of each vertex.
std::vector<std::array<std::uint32_t, 2>> self_intersections(const MeshModel& mesh,
                                                             std::span<const std::uint32_t> first,
                                                             const PartRunner& parts);

/// Reports a mesh's self-intersections one by one until `visitor` returns false.
SearchEnd visit_self_intersections(const MeshModel& mesh, std::span<const std::uint32_t> first,
                                   const std::function<bool(const std::array<std::uint32_t, 2>&)>& visitor,
                                   const SearchOptions& options);

}  // namespace tandem
