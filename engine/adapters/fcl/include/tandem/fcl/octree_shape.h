#pragma once
#include <fcl/config.h>
#if FCL_HAVE_OCTOMAP
#include <fcl/geometry/octree/octree.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tandem/narrowphase/shape_makers.h"

namespace tandem::fcl {

/// The occupied cells of an octree, such as one read from a file of octomap's, as one solid (tandem::voxels) in cells
/// as small as the smallest of them. Empty where none is occupied. Throws std::invalid_argument for more than 2^24
/// cells.
template <class S>
std::optional<Shape> to_voxels(const ::fcl::OcTree<S>& octree) {
  constexpr std::size_t most = std::size_t{1} << 24;
  const auto boxes = octree.toBoxes();  // centre, size
  if (boxes.empty()) return std::nullopt;
  double size = std::numeric_limits<double>::infinity(), count = 0;
  for (const auto& box : boxes) size = std::min(size, double{box[3]});
  for (const auto& box : boxes) count += std::pow(std::round(box[3] / size), 3);
  if (count > static_cast<double>(most))
    throw std::invalid_argument("octree: the number of cells is " + std::to_string(count) +
                                ", allowed: <= " + std::to_string(most));
  std::vector<std::array<std::int32_t, 3>> cells;
  for (const auto& box : boxes) {
    const auto edge = static_cast<std::int32_t>(std::lround(box[3] / size));
    const auto first = [&](std::size_t k) {
      return static_cast<std::int32_t>(std::lround((box[k] - box[3] / 2) / size));
    };
    for (std::int32_t i = 0; i < edge * edge * edge; ++i)
      cells.push_back({first(0) + i % edge, first(1) + i / edge % edge, first(2) + i / edge / edge});
  }
  return voxels(cells, size);
}

}  // namespace tandem::fcl
#endif  // FCL_HAVE_OCTOMAP
