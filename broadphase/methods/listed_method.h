#pragma once
#include <cstddef>

#include "methods/box_search.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem {

/// About what a method takes for a step, in nanoseconds; only ratios count. Measured on one thread with AVX2.
struct MethodCosts {
  double box = 0, pair = 0;              ///< of a step from scratch
  double listed_box = 0, candidate = 0;  ///< of one that also makes a list of the candidates
};

/// A method whose pairs can be kept (VerletList).
class ListedMethod : public BroadPhase {
 public:
  virtual MethodCosts costs(std::size_t boxes) const = 0;
  /// To look in what was last built; nullptr: it cannot be searched, which is for few boxes.
  virtual BoxSearch* search_in() { return nullptr; }
};

}  // namespace tandem
