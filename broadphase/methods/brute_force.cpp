// The broad phase that tests all pairs of boxes.
#include "methods/brute_force.h"

#include <algorithm>
#include <array>

#include "kernels/row_kernel.h"

namespace tandem {

std::size_t BruteForce::begin(const BoxArray& boxes) {
  boxes_ = &boxes;
  if (boxes.size() != size_) {
    size_ = boxes.size();
    const auto n = static_cast<std::uint32_t>(size_);
    tiles_.clear();
    for (std::uint32_t row = 0; row < n; row += tile_rows)
      for (std::uint32_t column = row / tile_columns * tile_columns; column < n; column += tile_columns)
        tiles_.push_back({row, column});
  }
  return 1;
}

void BruteForce::emit(std::size_t block, PairSink& sink) {
  const Tile tile = tiles_[block];
  const std::size_t row_end = std::min<std::size_t>(tile.row + tile_rows, size_);
  const std::size_t column_end = std::min<std::size_t>(tile.column + tile_columns, size_);
  std::array<std::uint32_t, tile_columns + BoxArray::padding> hits;
  for (std::size_t i = tile.row; i < row_end; ++i) {
    const std::size_t first = std::max<std::size_t>(tile.column, i + 1);
    if (first >= column_end) break;
    const std::size_t count = overlap_row(*boxes_, first, column_end, (*boxes_)[i], hits.data());
    for (std::size_t k = 0; k < count; ++k) sink.put(static_cast<std::uint32_t>(i), hits[k]);
  }
}

}  // namespace tandem
