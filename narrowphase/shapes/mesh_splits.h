// How a hierarchy parts its triangles: which come under which node, before any node has boxes.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "lanes/four_floats.h"
#include "shapes/build_meter.h"
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// A node of the hierarchy. Nodes lie in depth-first order: the first child behind its parent, each next sibling behind
/// the subtree of the one before.
struct SplitNode {
  std::uint32_t begin = 0, end = 0;  ///< of the triangles that were given, in their new order
  std::uint32_t nodes = 1;           ///< of its subtree, itself among them
  std::uint32_t bottoms = 0;         ///< of these, those that hold triangles
  std::uint32_t lanes = 0;           ///< children; triangles of a bottom node

  bool bottom() const { return nodes == 1; }
};

struct SplitTree {
  std::vector<SplitNode> nodes;
  int depth = 0;  ///< the level of the lowest nodes
};

/// Threads share the work of ranges of more triangles; smaller ones are one thread's.
inline constexpr std::uint32_t shared_above = 16'384;

/// Puts triangles in the order of the leaves of a tree whose root is at this level. `corners` are the mesh's vertices
/// in its units. The same on any number of threads, which `parts` (may be empty: the caller) stands for.
SplitTree split_triangles(const MeshModel& mesh, std::span<const FourFloats> corners,
                          std::span<std::uint32_t> triangles, int level, const PartRunner& parts, BuildMeter& meter);

}  // namespace tandem
