// Divides a mesh's triangles among the nodes of its hierarchy, before any node has boxes.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "lanes/four_floats.h"
#include "shapes/build_meter.h"
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// A node of the hierarchy. Nodes are in depth-first order: the first child after its parent, each sibling after the
/// subtree of the one before.
struct SplitNode {
  std::uint32_t begin = 0, end = 0;  ///< range of the given triangles, in their new order
  std::uint32_t nodes = 1;           ///< in its subtree, including itself
  std::uint32_t bottoms = 0;         ///< number of these that have triangles
  std::uint32_t lanes = 0;           ///< children; triangles of a bottom node

  bool bottom() const { return nodes == 1; }
};

struct SplitTree {
  std::vector<SplitNode> nodes;
  int depth = 0;  ///< level of the lowest nodes
};

/// Several threads work on ranges of more triangles than this; smaller ones belong to one thread.
inline constexpr std::uint32_t shared_above = 16'384;

/// Sorts triangles into the order of the leaves of a tree whose root is at this level. `corners` are the mesh's
/// vertices in its units. The same for any number of threads of `parts` (empty: the caller).
SplitTree split_triangles(const MeshModel& mesh, std::span<const FourFloats> corners,
                          std::span<std::uint32_t> triangles, int level, const PartRunner& parts, BuildMeter& meter);

}  // namespace tandem
