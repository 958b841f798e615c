// A box in half a cache line.
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

/// Copies boxes [begin, end) to the records of the same indices, if `records` is not null. Writes the indices of the
/// boxes that are not inside the box of the same index in `within` to `outside`, ascending, and their records of the
/// step before to `before`; returns how many. Both need room for end - begin elements. An empty box is inside every
/// box.
std::size_t copy_boxes_that_left(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray& within,
                                 BoxRecord* records, std::uint32_t* outside, BoxRecord* before);

/// The number of boxes [begin, end) that are not inside the box of the same index in `within`.
std::size_t count_boxes_that_left(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray& within);

/// The number of bytes that are not 0.
std::size_t count_set(std::span<const std::uint8_t> bytes);
/// Writes the indices of the bytes [begin, end) that are not 0 to `out`, ascending, and returns how many.
std::size_t indices_set(std::span<const std::uint8_t> bytes, std::size_t begin, std::size_t end, std::uint32_t* out);

/// The usual motion and size of the boxes of a world.
struct UsualBox {
  float motion = 0;  ///< in a step: most boxes move by less than half of it
  float edge = 0;    ///< most boxes' edges are not longer
};

/// Sets larger[begin, end): each box swept along its motion since `past`, a step ago, for some steps, but on no side by
/// more than its size or the usual motion times steps; then grown by a fraction of its size, up to the usual size, and
/// of its motion. A box that moved by more than half its size and more than is usual, or was empty, is taken to have
/// jumped and is not swept. The enlarged box contains the box; an empty box stays empty.
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
/// Copies the boxes of bodies[k] to out[k] from the box array: six cache lines a box instead of one.
void gather_boxes(const BoxArray& boxes, const std::uint32_t* bodies, std::size_t count, BoxRecord* out);

/// A pair by indices of 16 bits, into up to 65536 records.
struct LocalPair {
  std::uint16_t a, b;
};

/// Writes the pairs, of `count`, whose records overlap to `out`, in their order, and returns how many. `out` needs room
/// for `count` and may not overlap `pairs`.
std::size_t overlapping(const BoxRecord* records, const LocalPair* pairs, std::size_t count, LocalPair* out);

}  // namespace tandem
