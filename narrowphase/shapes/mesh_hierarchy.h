// The hierarchy of boxes over a mesh's triangles.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "shapes/mesh_model.h"
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// Fills nodes, blocks, slabs, order and depth of a mesh that has vertices, triangles, centre, half and unit. The same on
/// any number of threads; `parts` (may be empty: the caller) shares the subtrees.
void build_hierarchy(MeshModel& mesh, const PartRunner& parts);

/// A hierarchy, or a subtree of one, by itself: the root is nodes[0], children come after their parents and those of a
/// subtree one after another.
struct HierarchyTree {
  std::vector<MeshNode> nodes;
  std::vector<TriangleBlock> blocks;
  std::vector<ChildSlabs> slabs;
  int depth = 0;  ///< the level of the lowest nodes; that of a whole hierarchy's root is 1

  /// Puts another's nodes behind one's own; answers the place of the first.
  std::uint32_t append(const HierarchyTree& other);
};

/// A subtree at this level over some of the mesh's triangles, which are order[place ...] and are put in the leaves' order.
HierarchyTree build_subtree(const MeshModel& mesh, std::span<std::uint32_t> triangles, std::uint32_t place, int level,
                            const PartRunner& parts);

/// How far the mesh extends along a direction in its frame: the most of direction . vertex, of the vertices in use.
double farthest_along(const MeshModel& mesh, const Vec3& direction);

}  // namespace tandem
