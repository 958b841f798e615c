#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <span>

#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/batch.h"

namespace tandem {

/// The threads of a step, for work within a batch that several can share.
class Crew {
 public:
  virtual ~Crew() = default;
  /// Runs part(0) ... part(parts - 1) on the calling thread and those of the step that have nothing else to do; returns
  /// when all are done, throws what a part threw.
  virtual void share(std::size_t parts, const std::function<void(std::size_t)>& part) = 0;
};

/// The costly ones among some pairs: the first `all` may cost far more than the others, and of these the first
/// `costliest` will be the longest of all.
struct HeavyPairs {
  std::size_t costliest = 0, all = 0;
};

/// The work of one step, described once for all executors. Stages of independent blocks: the first turns poses into
/// boxes, the last emits candidate pairs, those between prepare the broad phase. Within a stage blocks run in any
/// order on any thread; a stage starts when the one before it is done. Batches of emitted pairs may go to `narrow`
/// while the last stage still runs.
class StepWork {
 public:
  virtual ~StepWork() = default;

  /// Starts a step; returns the number of stages, at least 2.
  virtual std::size_t begin() = 0;
  /// Sets the crew that `narrow` may ask for help until the step ends; null: the caller is alone. Before begin().
  virtual void work_with(Crew*) {}
  /// Tells, until the step ends, whether the rest of it is not wanted any more: stopped, cancelled or failed. Long work
  /// within a batch may ask, from any thread, and leave its answers as they are. Before begin().
  virtual void ended_by(std::function<bool()>) {}
  /// Blocks of a stage; asked for once the stages before it are done.
  virtual std::size_t blocks(std::size_t stage) const = 0;
  virtual void run(std::size_t stage, std::size_t block) = 0;
  virtual void emit(std::size_t block, PairSink& sink) = 0;

  virtual const PairFilter& filter() const = 0;
  /// The user's predicate on a batch of candidates; see PairPredicate.
  virtual std::size_t keep(std::span<Pair> pairs) const = 0;
  /// Moves the pairs that may cost far more than the others to the front, of these first the costliest, and returns how
  /// many there are; they travel in small batches of their own and are narrowed first, so that none is left for the
  /// end.
  /// `batch`: what a batch should take; who takes less is not among the costliest, since it can travel with others.
  virtual HeavyPairs heavy_first(std::span<Pair>, std::chrono::nanoseconds /*batch*/) const { return {}; }
  /// What the narrow phase of a batch with heavy pairs took, to guess by in the next step. From many threads at once.
  virtual void took(const Batch&, std::chrono::nanoseconds) const {}
  /// Fills the batch's results from its pairs. From many threads at once, on different batches.
  virtual void narrow(Batch& batch) const = 0;
  /// One past the largest body index.
  virtual std::size_t bodies() const = 0;
};

}  // namespace tandem
