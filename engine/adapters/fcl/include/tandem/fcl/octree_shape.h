// FCL's octrees as voxels.
#pragma once
#include <fcl/config.h>
#if FCL_HAVE_OCTOMAP
#include <fcl/geometry/octree/octree.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "tandem/narrowphase/shape.h"

namespace tandem::fcl {

/// The occupied leaves of an octree, such as one read from a file of octomap's, as voxels whose smallest cells are the
/// smallest of them. Empty where none is occupied. Throws std::invalid_argument as Shape(Voxels) does.
template <class S>
std::optional<Shape> to_voxels(const ::fcl::OcTree<S>& octree) {
  const auto boxes = octree.toBoxes();  // centre, size
  if (boxes.empty()) return std::nullopt;
  Voxels voxels;
  voxels.cell_size = std::numeric_limits<double>::infinity();
  for (const auto& box : boxes) voxels.cell_size = std::min(voxels.cell_size, double{box[3]});
  voxels.cells.reserve(boxes.size());
  for (const auto& box : boxes) {
    VoxelCell cell;
    for (std::size_t k = 0; k < 3; ++k)
      cell.corner[k] = static_cast<std::int32_t>(std::lround((box[k] - box[3] / 2) / voxels.cell_size));
    cell.level = static_cast<std::uint8_t>(std::lround(std::log2(box[3] / voxels.cell_size)));
    voxels.cells.push_back(cell);
  }
  return Shape(voxels);
}

}  // namespace tandem::fcl
#endif  // FCL_HAVE_OCTOMAP
