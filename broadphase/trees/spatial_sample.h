// A small sample of boxes, for the choice of parameters.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/broadphase/box_array.h"

namespace tandem {

/// A few hundred boxes spread over the index range, without empty ones. The choice depends only on the number of boxes.
/// It takes microseconds at any size, and is enough to choose cell sizes from: errors of a sample cost time, never
/// pairs.
std::vector<Aabb> sample_boxes(const BoxArray& boxes, const std::vector<std::uint32_t>* subset = nullptr);

/// The range of the bulk of the sample on an axis: without the outermost 2 % of lower bounds on each side, then
/// enlarged by a sixteenth, so that a few bodies far away do not set the scale. hi >= lo.
struct Extent {
  double lo = 0, hi = 0;
};
Extent bulk(const std::vector<Aabb>& sample, std::size_t axis);

/// A cube that maps centres of boxes to Morton codes; centres outside count as on its surface.
struct Cube {
  std::array<double, 3> lo{};
  double inverse_side = 0;

  /// The Morton code of the box's centre, `bits` an axis, at most 10.
  std::uint32_t morton(const Aabb& box, int bits) const;
};

}  // namespace tandem
