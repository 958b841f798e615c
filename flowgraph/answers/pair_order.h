// The sorting of candidate pairs in stages of independent blocks.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "tandem/flowgraph/batch.h"

namespace tandem {

/// A pair as one number: a << 32 | b.
inline Pair pair_of(std::uint64_t key) {
  return {static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key)};
}

/// Sorts candidate pairs by (a, b), each pair given once, in stages of independent blocks: groups of batches count
/// their pairs by ranges of a, scatter them into these ranges, and the ranges are sorted one by one. The serial part is
/// a sum over groups times ranges: at most 32 times the smaller of 4096 and an eighth of the pairs; with a single
/// group, the larger of 65536 and half of the pairs.
class PairOrder {
 public:
  static constexpr std::size_t stages = 3;

  /// Begins a sort. Body indices are below `bodies`. The batches must stay as they are until the second stage is over.
  void begin(std::span<Batch* const> batches, std::size_t bodies);
  /// The serial work before a stage; returns the number of its blocks.
  std::size_t open(std::size_t stage);
  void run(std::size_t stage, std::size_t block);
  /// Runs all stages on the calling thread. If the pairs and their order are those of the last call, the sorted pairs
  /// are kept.
  void sort(std::span<Batch* const> batches, std::size_t bodies);

  /// The sorted pairs, after the last stage: a << 32 | b, ascending; pair_of() reads one.
  std::span<const std::uint64_t> sorted() const { return keys_; }
  std::size_t memory() const {
    return (next_.capacity() + first_.capacity()) * sizeof(std::uint32_t) +
           (keys_.capacity() + spare_.capacity()) * sizeof(std::uint64_t) + given_.capacity() * sizeof(Pair);
  }

 private:
  using Range = std::pair<std::size_t, std::size_t>;
  static constexpr std::size_t pairs_a_group = 2048, most_groups = 32, pairs_a_block = 1024;

  void prepare(std::span<Batch* const> batches, std::size_t bodies, std::size_t groups);
  /// True if the pairs are known to be those of the last call of sort().
  bool same_again(std::span<Batch* const> batches);
  std::span<Batch* const> group(std::size_t block) const;
  std::span<std::uint32_t> row(std::size_t group);
  void count(std::size_t group);
  void to_places();
  void scatter(std::size_t group);
  void sort_ranges(std::size_t block);
  /// The ranges of a whose first pairs lie in a block.
  Range ranges(std::size_t block) const;

  std::span<Batch* const> batches_;
  std::size_t groups_ = 1, ranges_ = 1, row_ = 1;
  int shift_ = 0;                     // maps a to the number of its range
  std::vector<std::uint32_t> next_;   // a row a group: where its next pair of a range goes
  std::vector<std::uint32_t> first_;  // the first pair of each range
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint64_t> spare_;  // scratch to sort long ranges with
  std::size_t last_total_ = 0;        // number of pairs given to the last sort()
  std::vector<Pair> given_;           // the pairs given to the last sort(), if the call before had as many
  bool is_sorted_ = false;            // keys_ are those of the last sort(), sorted
};

}  // namespace tandem
