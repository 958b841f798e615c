// Search for the overlapping pairs within a column of the grid.
#pragma once
#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "kernels/column_kernel.h"
#include "storage/memory.h"

namespace tandem {

/// Working memory for finding the pairs of a column.
struct ColumnScratch {
  Column column;
  std::vector<RowHits> hits;
  std::vector<RowPair> pairs;
  std::size_t memory() const { return column.memory() + bytes_of(hits) + bytes_of(pairs); }
};

/// Calls take(pairs) with the pairs of the sorted scratch.column, a few at a time.
template <class Take>
void each_pair(ColumnScratch& scratch, const Take& take) {
  constexpr std::size_t hits_at_once = 256, pairs_a_hit = 16;
  const std::size_t size = scratch.column.size;
  if (scratch.hits.size() < size + 1024) scratch.hits.resize(size + 1024);
  scratch.pairs.resize(hits_at_once * pairs_a_hit);
  for (std::size_t row = 0; row < size;) {
    const std::size_t found = overlap_column(scratch.column, row, scratch.hits.data(), scratch.hits.size());
    for (std::size_t first = 0; first < found; first += hits_at_once) {
      const std::size_t count = std::min(hits_at_once, found - first);
      take(std::span(scratch.pairs.data(), pairs_of_hits(scratch.hits.data() + first, count, scratch.pairs.data())));
    }
  }
}

}  // namespace tandem
