// A batch of pairs with its answers.
#pragma once
#include <chrono>
#include <cstddef>
#include <vector>

#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// Shortest time of a batch: one that takes less costs too much to hand on, and a pair that takes longer may travel
/// alone.
inline constexpr std::chrono::nanoseconds shortest_batch{15'000};

/// A batch, which goes from the broad to the narrow phase: candidate pairs, and room for their answers.
struct Batch {
  std::vector<Pair> pairs;  ///< room; the first `count` are candidates
  std::size_t count = 0;
  std::size_t id = 0;  ///< number within the step, in the order in which batches were begun
  bool heavy = false;  ///< true: pairs that may cost much more than others
  /// True: the heavy pairs that cost the most in the last step, to be begun before all others
  bool costliest = false;
  std::vector<PairResult> results;  ///< first_contact counts within `contacts`
  std::vector<Contact> contacts;
  bool inexact = false;  ///< some answer did not reach the tolerance

  /// Empties it; leaves room for `capacity` pairs.
  void clear(std::size_t capacity);
  /// Bytes held, without sizeof(Batch).
  std::size_t memory() const;
};

}  // namespace tandem
