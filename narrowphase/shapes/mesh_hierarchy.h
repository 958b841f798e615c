// The bounding volume hierarchy of a mesh's triangles.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "lanes/four_floats.h"
#include "shapes/build_meter.h"
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/part_runner.h"

namespace tandem {

/// Fills nodes, blocks, boxes, slabs, order and depth of a mesh that has vertices, triangles, centre, half and unit.
/// The same hierarchy for any number of threads; `parts` (empty: the caller) distributes the subtrees.
void build_hierarchy(MeshModel& mesh, const PartRunner& parts);
void build_hierarchy(MeshModel& mesh, const PartRunner& parts, BuildMeter& meter);

/// The work of building a hierarchy, in units of the meter.
constexpr std::size_t hierarchy_work(std::size_t triangles) { return 2 * triangles; }

/// Vertices in units of the mesh relative to its centre, as hierarchies store them: x, y, z, 0.
using CornersInUnits = UninitialisedList<FourFloats>;
CornersInUnits corners_in_units(const MeshModel& mesh, const PartRunner& parts);
/// The same for other vertices, with the mesh's centre and unit.
void place_corners(const MeshModel& mesh, std::span<const Vec3> vertices, const PartRunner& parts,
                   CornersInUnits& corners);

/// A hierarchy, or a subtree of one: the root is nodes[0], children come after their parents and those of a subtree
/// consecutively.
struct HierarchyTree {
  UninitialisedList<MeshNode> nodes;
  UninitialisedList<TriangleBlock> blocks;
  UninitialisedList<ChildBoxes> boxes;
  UninitialisedList<ChildSlabs> slabs;
  int depth = 0;  ///< the level of the lowest nodes; that of a whole hierarchy's root is 1

  /// Appends another's nodes; returns the index of the first.
  std::uint32_t append(const HierarchyTree& other);
};

/// Builds a subtree at this level over some of the mesh's triangles, which are order[place ...] and are sorted into the
/// leaves' order.
HierarchyTree build_subtree(const MeshModel& mesh, std::span<const FourFloats> corners,
                            std::span<std::uint32_t> triangles, std::uint32_t place, int level, const PartRunner& parts,
                            BuildMeter& meter);

/// The box of a triangle, as tight as those of inner nodes.
void box_of_triangle(const MeshModel& mesh, std::uint32_t triangle, float (&mid)[3], float (&half)[3]);

/// The extent of the mesh along a direction in its frame: the maximum of direction . vertex over the used vertices.
double farthest_along(const MeshModel& mesh, const Vec3& direction);

}  // namespace tandem
