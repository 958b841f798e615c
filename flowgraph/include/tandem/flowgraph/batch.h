#pragma once
#include <chrono>
#include <cstddef>
#include <vector>

#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/contact_list.h"

namespace tandem {

/// A batch of pairs that takes less costs too much to hand on; a pair that takes longer may travel alone.
inline constexpr std::chrono::nanoseconds shortest_batch{15'000};

/// What travels from the broad to the narrow phase: candidate pairs, and the slot for what becomes of them.
struct Batch {
  std::vector<Pair> pairs;  ///< room; the first `count` are candidates
  std::size_t count = 0;
  std::size_t id = 0;               ///< counted in a step, in the order in which batches were begun
  bool heavy = false;               ///< pairs that may cost much more than others
  bool costliest = false;           ///< heavy ones that cost the most in the last step: to be begun before all others
  std::vector<PairResult> results;  ///< first_contact counts within `contacts`
  std::vector<Contact> contacts;
  bool inexact = false;  ///< some answer did not reach the tolerance

  /// Empty, with room for `capacity` pairs.
  void clear(std::size_t capacity);
  /// Bytes held beside itself.
  std::size_t memory() const;
};

}  // namespace tandem
