// Sets of boxes per slab of each axis, and their intersection for a box.
#include "queries/interval_bits.h"

#include <cmath>
#include <limits>

namespace tandem {

void IntervalBits::build(const BoxArray& boxes) {
  const std::size_t n = boxes.size();
  words_ = n > most ? 0 : (n + 63) / 64;
  sets_.assign(6 * slabs * words_, 0);
  places_.assign(words_ == 0 ? 0 : n, {});
  if (!is_built()) return;
  for (int axis = 0; axis < 3; ++axis) {
    float least = std::numeric_limits<float>::max(), greatest = -least;
    for (std::size_t i = 0; i < n; ++i)
      if (boxes.lo(axis)[i] <= boxes.hi(axis)[i]) {
        least = std::min(least, boxes.lo(axis)[i]);
        greatest = std::max(greatest, boxes.hi(axis)[i]);
      }
    const auto k = static_cast<std::size_t>(axis);
    const float extent = greatest - least, per_metre = static_cast<float>(slabs) / extent;
    const bool is_cut = extent > 0 && std::isfinite(extent) && std::isfinite(per_metre);
    origin_[k] = is_cut ? least : 0;
    extent_[k] = is_cut ? extent : 0;
    per_metre_[k] = is_cut ? per_metre : 0;
  }
  for (std::uint32_t i = 0; i < n; ++i) move(i, boxes[i]);
  if (!divides(boxes)) words_ = 0;
}

// If one large box determines the extent, all others may lie in one slab: a hierarchy is then faster.
bool IntervalBits::divides(const BoxArray& boxes) const {
  constexpr std::size_t most_per_overlap = 8;
  std::size_t visited = 0, overlapping = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const Aabb box = boxes[i];
    if (!(box.lo[0] <= box.hi[0])) continue;
    visit_near(ends_of(box), [&](std::uint32_t other) {
      ++visited;
      overlapping += overlap(boxes[other], box) ? 1 : 0;
      return true;
    });
  }
  return visited <= most_per_overlap * overlapping;
}

void IntervalBits::turn(std::size_t which, std::size_t first, std::size_t last, std::uint32_t index) {
  for (std::size_t s = first; s < last; ++s)
    sets_[(which * slabs + s) * words_ + index / 64] ^= std::uint64_t{1} << index % 64;
}

void IntervalBits::move(std::uint32_t index, const Aabb& box) {
  if (!is_built()) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Place& now = places_[index][axis];
    Place next;
    if (box.lo[axis] <= box.hi[axis]) {
      next.begin = slab(axis, box.lo[axis]);
      next.past = static_cast<std::uint8_t>(slab(axis, box.hi[axis]) + 1);
    }
    turn(2 * axis, std::min(now.begin, next.begin), std::max(now.begin, next.begin), index);
    turn(2 * axis + 1, std::min(now.past, next.past), std::max(now.past, next.past), index);
    now = next;
  }
}

IntervalBits::Ends IntervalBits::ends_of(const Aabb& box) const {
  return {slab(0, box.hi[0]), slab(0, box.lo[0]), slab(1, box.hi[1]),
          slab(1, box.lo[1]), slab(2, box.hi[2]), slab(2, box.lo[2])};
}

void IntervalBits::find_ends(const BoxArray& boxes, std::size_t count, EndsOfBoxes& out) const {
  for (std::size_t end = 0; end < 6; ++end) {
    if (out.ends_[end].size() < count) out.ends_[end].resize(count);
    const auto axis = static_cast<int>(end / 2);
    const float* const from = end % 2 == 0 ? boxes.hi(axis) : boxes.lo(axis);
    std::uint8_t* const to = out.ends_[end].data();
    for (std::size_t i = 0; i < count; ++i) to[i] = slab(end / 2, from[i]);
  }
}

std::size_t IntervalBits::memory() const {
  return sets_.capacity() * sizeof(sets_[0]) + places_.capacity() * sizeof(places_[0]);
}

}  // namespace tandem
