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

}  // namespace tandem
