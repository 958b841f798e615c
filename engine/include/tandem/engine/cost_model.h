// A user's cost model of pairs.
#pragma once
#include <chrono>
#include <functional>
#include <memory>
#include <span>

#include "tandem/broadphase/pair.h"

namespace tandem {

class Scene;

/// A user's estimate of the costs of pairs. Costly pairs travel in small batches, and those that may take longer than a
/// batch alone, before all others; the answer does not depend on it.
class CostModel {
 public:
  virtual ~CostModel() = default;
  /// Called before each step, on the thread that runs it. The scene does not change until the step ends.
  virtual void begin_step(const Scene&) {}
  /// The estimated time of the narrow phase of a pair. Called from many threads at once, also for pairs that are not
  /// narrowed in the end; must return the same whenever it is called within a step.
  virtual std::chrono::nanoseconds guess(Pair pair) const = 0;
  /// Reports the time of the narrow phase of some pairs, of which one or all were estimated to be costly. Called from
  /// many threads at once.
  virtual void took(std::span<const Pair>, std::chrono::nanoseconds) {}
};

using CostModelFactory = std::function<std::unique_ptr<CostModel>()>;

}  // namespace tandem
