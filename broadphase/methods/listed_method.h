// Methods whose candidates can be kept between steps, with their estimated costs.
#pragma once
#include <cstddef>

#include "methods/box_search.h"
#include "tandem/broadphase/broad_phase.h"

namespace tandem {

/// The estimated time of a method for a step, in nanoseconds; only ratios matter. Measured on one thread with AVX2.
struct MethodCosts {
  double box = 0, pair = 0;              ///< in a step from scratch
  double listed_box = 0, candidate = 0;  ///< in a step that also makes a list of the candidates
};

/// A method whose candidates can be kept in a VerletList.
class ListedMethod : public BroadPhase {
 public:
  virtual MethodCosts costs(std::size_t boxes) const = 0;
  /// The interface to search the boxes of the last step; nullptr: the method has none, and is meant for few boxes.
  virtual BoxSearch* search_in() { return nullptr; }
};

}  // namespace tandem
