#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/broadphase/box_array.h"

namespace tandem {

/// A few hundred boxes spread over the index range, empty ones left out. The choice depends on the number of boxes
/// only. Cheap (microseconds) at any size, and enough to choose cell sizes from: what a sample gets wrong costs
/// time, never pairs.
std::vector<Aabb> sample_boxes(const BoxArray& boxes, const std::vector<std::uint32_t>* subset = nullptr);

/// Where the bulk of the sample lies on an axis: a range that leaves out the outermost 2 % of lower bounds on each
/// side, then grows by a sixteenth, so that a few bodies far away do not set the scale. hi >= lo.
struct Extent {
  double lo = 0, hi = 0;
};
Extent bulk(const std::vector<Aabb>& sample, std::size_t axis);

/// A cube that maps centres of boxes to Morton codes; what lies outside counts as on its surface.
struct Cube {
  std::array<double, 3> lo{};
  double inverse_side = 0;

  /// `bits` an axis, at most 10.
  std::uint32_t morton(const Aabb& box, int bits) const;
};

}  // namespace tandem
