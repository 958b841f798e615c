#pragma once
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

}  // namespace tandem
