// A sample of the boxes, their extent without outliers, and Morton codes.
#include "trees/spatial_sample.h"

#include <algorithm>

namespace tandem {
namespace {

/// Inserts two zeros before each of the low 10 bits.
std::uint32_t spread_bits(std::uint32_t x) {
  x = (x | x << 16) & 0x030000ffu;
  x = (x | x << 8) & 0x0300f00fu;
  x = (x | x << 4) & 0x030c30c3u;
  x = (x | x << 2) & 0x09249249u;
  return x;
}

}  // namespace

std::vector<Aabb> sample_boxes(const BoxArray& boxes, const std::vector<std::uint32_t>* subset) {
  constexpr std::size_t wanted = 384;
  const std::size_t n = subset != nullptr ? subset->size() : boxes.size();
  std::vector<Aabb> sample;
  sample.reserve(std::min(n, wanted));
  const std::size_t strata = std::min(n, wanted);
  std::uint64_t state = 1;
  for (std::size_t s = 0; s < strata; ++s) {
    // Takes one box of each of equal index ranges, at a pseudo-random place: a fixed stride would resonate with scenes
    // that are made row by row.
    const std::size_t first = s * n / strata, last = (s + 1) * n / strata;
    state = state * 6364136223846793005u + 1442695040888963407u;
    const std::size_t i = first + (state >> 33) % (last - first);
    const Aabb box = boxes[subset != nullptr ? (*subset)[i] : i];
    if (box.lo[0] <= box.hi[0]) sample.push_back(box);
  }
  return sample;
}

Extent bulk(const std::vector<Aabb>& sample, std::size_t axis) {
  if (sample.empty()) return {};
  std::vector<float> lower(sample.size());
  for (std::size_t i = 0; i < sample.size(); ++i) lower[i] = sample[i].lo[axis];
  const auto quantile = [&](std::size_t rank) {
    const auto place = lower.begin() + static_cast<std::ptrdiff_t>(rank);
    std::nth_element(lower.begin(), place, lower.end());
    return double{*place};
  };
  const std::size_t outer = sample.size() / 50;
  const double lo = quantile(outer), hi = quantile(sample.size() - 1 - outer);
  const double more = (hi - lo) / 16;
  return {lo - more, hi + more};
}

std::uint32_t Cube::morton(const Aabb& box, int bits) const {
  const double cells = static_cast<double>(1u << bits);
  std::uint32_t code = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double centre = 0.5 * (double{box.lo[k]} + double{box.hi[k]});
    const double place = (centre - lo[k]) * inverse_side * cells;
    code |= spread_bits(static_cast<std::uint32_t>(std::clamp(place, 0.0, cells - 1))) << k;
  }
  return code;
}

}  // namespace tandem
