// Cells of a grid and a hierarchy of boxes over them.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// A reference into the hierarchy: a cell by its index, or a node by the number of cells plus its index.
using VoxelRef = std::uint32_t;

/// The cells in Morton order, in which neighbours follow each other: eight in a row are the children of a node, eight
/// nodes in a row those of a node above. Coordinates are whole numbers of cells, so that boxes are exact.
struct detail::VoxelModel {
  struct Node {
    std::array<std::int32_t, 3> lo, hi;  ///< the box around its children, in cells
    VoxelRef first;                      ///< the first child
    std::uint32_t count;                 ///< of children, 1..8
  };

  Vec3 origin;
  double cell_size;
  std::vector<VoxelCell> cells;
  std::vector<Node> nodes;   ///< from the lowest level to the root, which is last
  std::vector<Shape> boxes;  ///< the box of a cell of each level, up to the largest one

  bool is_cell(VoxelRef ref) const { return ref < cells.size(); }
  VoxelRef root() const { return static_cast<VoxelRef>(cells.size() + nodes.size() - 1); }
  const Node& node(VoxelRef ref) const { return nodes[ref - cells.size()]; }
  const Shape& box_of(VoxelRef cell) const { return boxes[cells[cell].level]; }

  /// Lowest and highest corner, in units of a smallest cell.
  std::pair<std::array<std::int32_t, 3>, std::array<std::int32_t, 3>> span_of(VoxelRef ref) const;
  /// Middle and half sizes in the shape's frame, metres.
  std::pair<Vec3, Vec3> box(VoxelRef ref) const;
  Vec3 centre(VoxelRef cell) const { return box(cell).first; }

  /// True if the smallest cell (i, j, k) is inside one of the cells.
  bool has(const std::array<std::int64_t, 3>& place) const;

  /// Visits, in order, the cells for which `enter(ref)` is true, as for all nodes above them. Ends when visit(cell)
  /// returns false, and then returns that.
  template <class Enter, class Visit>
  bool each_cell(Enter&& enter, Visit&& visit) const {
    std::array<VoxelRef, most_waiting> waiting;
    std::size_t count = 0;
    waiting[count++] = root();
    while (count > 0) {
      const VoxelRef ref = waiting[--count];
      if (!enter(ref)) continue;
      if (is_cell(ref)) {
        if (!visit(ref)) return false;
        continue;
      }
      const Node& n = node(ref);
      for (std::uint32_t k = n.count; k-- > 0;) waiting[count++] = n.first + k;
    }
    return true;
  }

  static constexpr std::size_t fan = 8;
  static constexpr std::size_t most_cells = std::size_t{1} << 26;  ///< contacts name a cell in 26 bits
  static constexpr std::size_t most_waiting = 1 + 7 * 10;  ///< 8^9 > most_cells: nine levels of nodes, one of cells
};
using detail::VoxelModel;

/// Throws std::invalid_argument that names the field, its value and what is allowed.
VoxelModel build_voxels(const Voxels& voxels);

MassProperties voxel_mass(const VoxelModel& voxels);

}  // namespace tandem
