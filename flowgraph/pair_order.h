#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "tandem/flowgraph/batch.h"

namespace tandem {

/// Sorts candidate pairs by (a, b) on one thread: two passes of counting, by b, then by a. The same pairs as the last
/// time, in the same order, are not sorted again.
class PairOrder {
 public:
  /// Over all batches, each of which keeps its number of pairs. Bodies are below `bodies`.
  void sort(std::span<Batch* const> batches, std::size_t bodies);

 private:
  /// Notes the pairs of all batches; true if they are those of the last time.
  bool same_again(std::span<Batch* const> batches);

  std::vector<Pair> given_, by_b_, sorted_;
  std::vector<std::uint32_t> next_a_, next_b_;  // a body: where its next pair goes
};

}  // namespace tandem
