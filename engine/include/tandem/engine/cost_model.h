#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <span>

#include "tandem/broadphase/pair.h"

namespace tandem {

class Scene;

/// A guess of one's own of what pairs cost. By it costly pairs travel in small batches, and those that may take longer
/// than a batch alone, before all others; the answer does not depend on it.
class CostModel {
 public:
  virtual ~CostModel() = default;
  /// Before each step, on the thread that runs it. The scene stays as it is until the step ends.
  virtual void begin_step(const Scene&) {}
  /// What the narrow phase of a pair will take. From many threads at once, also for pairs that are not narrowed at
  /// last; the same answer whenever it is asked within a step.
  virtual std::chrono::nanoseconds guess(Pair pair) const = 0;
  /// What the narrow phase of some pairs took, of which one or all were guessed to be costly. From many threads at
  /// once.
  virtual void took(std::span<const Pair>, std::chrono::nanoseconds) {}
};

using CostModelFactory = std::function<std::unique_ptr<CostModel>()>;

}  // namespace tandem
