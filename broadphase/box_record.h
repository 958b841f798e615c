#pragma once
#include <cstddef>
#include <cstdint>

#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

/// A box as two vectors of four, the last lanes zero: half a cache line, so that a box found by index costs one miss.
struct alignas(32) BoxRecord {
  float lo[4] = {};
  float hi[4] = {};

  Aabb box() const { return {{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}}; }
  void set(const Aabb& box) {
    for (std::size_t k = 0; k < 3; ++k) {
      lo[k] = box.lo[k];
      hi[k] = box.hi[k];
    }
  }
};

/// Copies boxes [begin, end) to the records of the same indices.
void copy_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, BoxRecord* records);

/// The place of a box that has no record.
inline constexpr std::uint32_t no_place = ~std::uint32_t{0};

/// Copies boxes [begin, end) to records[place[i]], those without a place to nowhere, and writes the indices of those
/// that are not inside the box of the same index in `within` to `outside`, ascending; returns how many. `outside` needs
/// room for end - begin + BoxArray::padding elements. An empty box is inside every box.
std::size_t place_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray& within,
                        const std::uint32_t* place, BoxRecord* records, std::uint32_t* outside);

/// Sets larger[begin, end): each box swept along its mean motion a step since `past`, `past_steps` >= 1 ago, for some
/// steps and grown a little, never by more than its size on a side or `usual`, a motion, times steps; a box that moved
/// by more than half its size a step and by more than `usual`, or was empty, jumped and is not expected to go on. Holds
/// the box; an empty box stays empty.
void enlarge_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxRecord* past, float past_steps,
                   float steps, float usual, BoxArray& larger);

/// Writes those of `count` pairs whose records overlap to `out`, in their order, and returns how many. `out` needs
/// room for `count` and may not overlap `pairs`.
std::size_t overlapping(const BoxRecord* records, const Pair* pairs, std::size_t count, Pair* out);

}  // namespace tandem
