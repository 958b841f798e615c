#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "tandem/broadphase/box_array.h"

namespace tandem {

/// Boxes that enter one column of a grid, ordered so that those that may overlap row i along the column and come
/// after it are rows i + 1 .. end[i] - 1. Arrays have size + BoxArray::padding elements.
struct Column {
  const BoxArray* boxes = nullptr;
  const std::uint32_t* index = nullptr;  ///< of the body
  const std::uint32_t* first = nullptr;  ///< bit k: the column is the body's first along column axis k
  const std::uint32_t* end = nullptr;
  std::size_t size = 0;
};

/// Tests rows from `row` on and writes the bodies of overlapping pairs to a and b; `row` moves to the first row not
/// tested: rows are done as long as what they may find has room. A pair that shares several columns is written in
/// the one that holds the lower corner of its intersection: the column that is, on each axis, the first of one of
/// the two. Returns the number of pairs. `room`, the size of a and b, must be at least size + BoxArray::padding.
std::size_t overlap_column(const Column& column, std::size_t& row, std::uint32_t* a, std::uint32_t* b,
                           std::size_t room);

/// Maps a coordinate to one of `count` slices, monotonically; what lies outside falls into the first or last.
struct Slices {
  std::size_t axis = 0;
  float half_origin = 0, inverse_half_width = 0;  // halves, so that differences are finite for all floats
  std::uint32_t count = 1;

  std::uint32_t at(float x) const {
    // 0 first in max, so that 0 * inf counts as 0.
    const float place = std::max(0.0f, (0.5f * x - half_origin) * inverse_half_width);
    return static_cast<std::uint32_t>(std::min(place, static_cast<float>(count - 1)));
  }
};

/// The slices of `count` coordinates, as `at` gives them; slices.count is at most 65535. Both arrays may be read and
/// written up to BoxArray::padding elements further.
void slices_of(const Slices& slices, const float* coordinates, std::size_t count, std::uint16_t* out);

}  // namespace tandem
