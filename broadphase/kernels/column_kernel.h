// Kernels of the grid: slices, and the columns that boxes touch.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/broadphase/box_array.h"

namespace tandem {

/// Maps a coordinate monotonically to one of `count` slices; coordinates outside fall into the first or last.
struct Slices {
  std::size_t axis = 0;
  float half_origin = 0, inverse_half_width = 0;  // halves, so that differences are finite for all floats
  std::uint32_t count = 1;

  std::uint32_t at(float x) const {
    // 0 is the first argument of max, so that 0 * inf counts as 0.
    const float place = std::max(0.0f, (0.5f * x - half_origin) * inverse_half_width);
    return static_cast<std::uint32_t>(std::min(place, static_cast<float>(count - 1)));
  }
};

/// The slices of `count` coordinates, as `at` gives them; slices.count is at most 65535. Both arrays may be read and
/// written up to BoxArray::padding elements further.
void slices_of(const Slices& slices, const float* coordinates, std::size_t count, std::uint16_t* out);

/// Writes the indices of boxes with lo < end and begin <= hi on an axis to `out`, ascending, and returns how many; once
/// they are more than `most` it may stop. `out` needs room for most + BoxArray::padding.
std::size_t boxes_in_slab(const BoxArray& boxes, std::size_t axis, float begin, float end, std::size_t most,
                          std::uint32_t* out);

/// A box that enters a column of a grid: half a cache line, eight values of four bytes that transpose as vectors.
struct alignas(32) ColumnRecord {
  Aabb box;
  std::uint32_t index;  ///< of the body
  std::uint32_t first;  ///< bit k: the column is the body's first along column axis k
};

/// An entry of a box in a column, to copy its record to the column's place.
struct ColumnEntry {
  std::uint32_t column;
  std::uint16_t box;    ///< counted from `begin`
  std::uint16_t first;  ///< see ColumnRecord
};
/// Entries of at most `max_boxes` boxes from `begin` on: each goes to records[place[column]++].
inline constexpr std::size_t max_boxes_a_scatter = 64;
void scatter_records(const BoxArray& boxes, std::size_t begin, const ColumnEntry* entries, std::size_t count,
                     std::uint32_t* place, ColumnRecord* records);

/// The boxes of a column sorted into thin cells along it. The later rows that row i may overlap are i + 1 ..
/// cell_end[last[i]] - 1. A vector of empty boxes follows the last row.
struct Column {
  std::size_t size = 0;
  Slices cells;
  std::array<std::vector<float>, 6> bounds;  ///< lo of axis 0, 1, 2, hi of axis 0, 1, 2
  std::vector<std::uint32_t> index, first;   ///< see ColumnRecord
  /// The first cell of each record, in the order of the records, and the last cell of each row.
  std::vector<std::uint32_t> cell, last;
  std::vector<std::uint32_t> cell_end;
  std::uint32_t longest = 0;       ///< the most cells from a row's first to its last
  std::vector<float> front, back;  ///< the sorted records, in two halves

  std::size_t memory() const;
};

/// Sorts `size` >= 1 records along `axis`.
void sort_column(const ColumnRecord* records, std::size_t size, std::size_t axis, Column& column);

/// Copies out the records in sorted order.
void copy_records(const Column& column, ColumnRecord* records);

/// The rows that one row overlaps: bit k of `bits` is row begin + k.
struct RowHits {
  std::uint32_t row, begin, bits;
};

/// Tests rows from `row` on, as long as the possible hits of a row have room, and sets `row` to the first one not
/// tested; returns the number of hits written. A pair that shares several columns is found in the one that holds the
/// lower corner of its intersection: the column that is, on each axis, the first of one of the two. `room` must be at
/// least column.size + 2.
///
/// There is no branch on whether a row hits: hits are unpredictable, and a wrong prediction costs as much as three
/// vectors. For the same reason a vector is not cut off at the last candidate; the rows behind it lie in later cells.
std::size_t overlap_column(const Column& column, std::size_t& row, RowHits* hits, std::size_t room);

/// Two rows of a column, row < other.
struct RowPair {
  std::uint32_t row, other;
};

/// Writes the pairs of `count` hits to `out`, in their order, and returns how many. `out` needs room for 16 pairs a
/// hit.
std::size_t pairs_of_hits(const RowHits* hits, std::size_t count, RowPair* out);

}  // namespace tandem
