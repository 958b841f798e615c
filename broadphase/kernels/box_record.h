#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

/// A box as two vectors of four, the last lanes zero: half a cache line, so that a box found by index costs one miss.
struct alignas(32) BoxRecord {
  float bounds[8] = {};

  float* lo() { return bounds; }
  float* hi() { return bounds + 4; }
  const float* lo() const { return bounds; }
  const float* hi() const { return bounds + 4; }
  void set(const Aabb& box) {
    for (std::size_t k = 0; k < 3; ++k) {
      bounds[k] = box.lo[k];
      bounds[4 + k] = box.hi[k];
    }
  }
};

inline bool overlap(const BoxRecord& p, const BoxRecord& q) {
  int hit = 1;
  for (std::size_t k = 0; k < 3; ++k) hit &= int{p.lo()[k] <= q.hi()[k]} & int{q.lo()[k] <= p.hi()[k]};
  return hit != 0;
}

/// Copies boxes [begin, end) to the records of the same indices.
void copy_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, BoxRecord* records);

/// Copies boxes [begin, end) to the records of the same indices, if there are any, and writes the indices of those that
/// are not inside the box of the same index in `within` to `outside`, ascending, and the records that they had to
/// `before`; returns how many. Both need room for end - begin elements. An empty box is inside every box.
std::size_t copy_boxes_that_left(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray& within,
                                 BoxRecord* records, std::uint32_t* outside, BoxRecord* before);

/// How many of the boxes [begin, end) are not inside the box of the same index in `within`.
std::size_t count_boxes_that_left(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray& within);

/// How many of some bytes are not 0.
std::size_t count_set(std::span<const std::uint8_t> bytes);
/// Writes the indices of those of bytes [begin, end) that are not 0 to `out`, ascending, and returns how many.
std::size_t indices_set(std::span<const std::uint8_t> bytes, std::size_t begin, std::size_t end, std::uint32_t* out);

/// What most boxes of a world do.
struct UsualBox {
  float motion = 0;  ///< in a step: most stay below half of it
  float edge = 0;    ///< most are not longer
};

/// Sets larger[begin, end): each box swept along its motion since `past`, a step ago, for some steps, never by more
/// than its size on a side or the usual motion times steps; and grown a little: by a share of its size, as far as that
/// is usual, and of its motion. A box that moved by more than half its size and more than is usual, or was empty,
/// jumped and is not expected to go on. Holds the box; an empty box stays empty.
void enlarge_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxRecord* past, float steps,
                   const UsualBox& usual, BoxArray& larger);

inline void prefetch_box(const BoxArray& boxes, std::size_t i) {
  for (int axis = 0; axis < 3; ++axis) {
    __builtin_prefetch(boxes.lo(axis) + i);
    __builtin_prefetch(boxes.hi(axis) + i);
  }
}

/// Copies records[bodies[k]] to out[k], for all k < count.
void gather_records(const BoxRecord* records, const std::uint32_t* bodies, std::size_t count, BoxRecord* out);
/// Copies the boxes of bodies[k] to out[k] from the boxes themselves: six cache lines a box instead of one.
void gather_boxes(const BoxArray& boxes, const std::uint32_t* bodies, std::size_t count, BoxRecord* out);

/// Two of some 65536 records.
struct LocalPair {
  std::uint16_t a, b;
};

/// Writes those of `count` pairs whose records overlap to `out`, in their order, and returns how many. `out` needs
/// room for `count` and may not overlap `pairs`.
std::size_t overlapping(const BoxRecord* records, const LocalPair* pairs, std::size_t count, LocalPair* out);

}  // namespace tandem
