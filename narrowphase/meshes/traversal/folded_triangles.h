// Triangles of a mesh that its other triangles cancel.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "meshes/traversal/triangle_pair.h"
#include "shapes/mesh_model.h"
#include "shapes/work_meter.h"

namespace tandem {

/// The folded ones among the triangles of a mesh that meet another mesh. A triangle and one of the opposite orientation
/// with the same corners enclose nothing, so that neither has an outside: of such ones only those of the more frequent
/// orientation have, since the surface remains without the others.
class FoldedTriangles {
 public:
  /// `side`: 0 for the first of each pair, 1 for the second.
  FoldedTriangles(const MeshModel& mesh, std::span<const TrianglePair> pairs, std::size_t side, WorkMeter& meter,
                  std::pmr::memory_resource* memory);

  bool empty() const { return folded_.empty(); }
  bool contain(std::uint32_t triangle) const;

 private:
  std::pmr::vector<std::uint32_t> folded_;  // sorted
};

}  // namespace tandem
