// A batch of candidate pairs and the room for its answers.
#include "tandem/flowgraph/batch.h"

namespace tandem {

void Batch::clear(std::size_t capacity) {
  if (pairs.size() < capacity) pairs.resize(capacity);
  count = 0;
  heavy = costliest = false;
  results.clear();
  contacts.clear();
  inexact = false;
}

std::size_t Batch::memory() const {
  return pairs.capacity() * sizeof(Pair) + results.capacity() * sizeof(PairResult) +
         contacts.capacity() * sizeof(Contact);
}

}  // namespace tandem
