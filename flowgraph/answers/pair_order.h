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

/// Sorts candidate pairs by (a, b), each pair given once, in stages of independent blocks: groups of batches are
/// counted by ranges of a, then scattered into these ranges, which are sorted one by one. Serial are sums over groups
/// times ranges, at most 32 times an eighth of the pairs or 4096; of one group half of the pairs or 65536.
class PairOrder {
 public:
  static constexpr std::size_t stages = 3;

  /// Bodies are below `bodies`. The batches stay as they are until the second stage is over.
  void begin(std::span<Batch* const> batches, std::size_t bodies);
  /// What is serial before a stage; returns its blocks.
  std::size_t open(std::size_t stage);
  void run(std::size_t stage, std::size_t block);
  /// All stages on the calling thread. The same pairs as the last time, in the same order, are not sorted again.
  void sort(std::span<Batch* const> batches, std::size_t bodies);

  /// After the last stage: a << 32 | b, ascending, see pair_of().
  std::span<const std::uint64_t> sorted() const { return keys_; }
  std::size_t memory() const {
    return (next_.capacity() + first_.capacity()) * sizeof(std::uint32_t) +
           (keys_.capacity() + other_.capacity()) * sizeof(std::uint64_t) + given_.capacity() * sizeof(Pair);
  }

 private:
  using Range = std::pair<std::size_t, std::size_t>;
  static constexpr std::size_t pairs_a_group = 2048, most_groups = 32, pairs_a_block = 1024;

  void prepare(std::span<Batch* const> batches, std::size_t bodies, std::size_t groups);
  /// Notes the pairs of all batches; true if they are those of the last call of sort().
  bool same_again(std::span<Batch* const> batches);
  std::span<Batch* const> group(std::size_t block) const;
  std::span<std::uint32_t> row(std::size_t group);
  void count(std::size_t group);
  void to_places();
  void scatter(std::size_t group);
  void sort_ranges(std::size_t block);
  /// The ranges of a that begin among a block's pairs.
  Range ranges(std::size_t block) const;

  std::span<Batch* const> batches_;
  std::size_t groups_ = 1, ranges_ = 1, row_ = 1;
  int shift_ = 0;                     // of a, to the number of its range
  std::vector<std::uint32_t> next_;   // a row a group: where its next pair of a range goes
  std::vector<std::uint32_t> first_;  // a range: its first pair
  std::vector<std::uint64_t> keys_;
  std::vector<std::uint64_t> other_;  // to sort long ranges with
  std::vector<Pair> given_;           // to the last sort()
  bool is_sorted_ = false;            // keys_ are those of given_
};

}  // namespace tandem
