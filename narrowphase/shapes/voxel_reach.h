// The support of voxels along a direction: branch and bound over their hierarchy.
#pragma once
#include <array>
#include <cstdint>

#include "shapes/work_meter.h"
#include "tandem/narrowphase/shape.h"
#include "tolerances.h"

namespace tandem {

/// The greatest bound(cell); bound(node) is no less than that of any cell below. The child with the greatest bound is
/// visited first, so that cells in a row, each farther than the last, are not all visited. Throws WorkStopped. Model:
/// VoxelModel.
template <class Model, class Bound>
double greatest_of_cells(const Model& voxels, Bound&& bound, WorkMeter& meter) {
  struct Waiting {
    double bound;
    std::uint32_t ref;
  };
  std::array<Waiting, Model::most_waiting> waiting;
  std::size_t count = 0;
  waiting[count++] = {bound(voxels.root()), voxels.root()};
  double most = -infinity;
  while (count > 0) {
    const Waiting top = waiting[--count];
    if (!(top.bound > most)) continue;
    if (voxels.is_cell(top.ref)) {
      most = top.bound;
      continue;
    }
    meter.spend();
    const auto& node = voxels.node(top.ref);
    const std::size_t first = count;
    for (std::uint32_t k = node.count; k-- > 0;) {
      const Waiting child{bound(node.first + k), node.first + k};
      std::size_t at = count++;
      for (; at > first && waiting[at - 1].bound > child.bound; --at) waiting[at] = waiting[at - 1];
      waiting[at] = child;
    }
  }
  return most;
}

/// The greatest height of the cells along a direction (shape's frame).
double farthest_along(const detail::VoxelModel& voxels, const Vec3& direction, const WorkLimit* limit);

}  // namespace tandem
