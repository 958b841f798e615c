// The work of a step as an executor sees it.
#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <span>

#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/batch.h"

namespace tandem {

/// The threads of a step, as helpers for work within a batch that several threads can share.
class Crew {
 public:
  virtual ~Crew() = default;
  /// Runs part(0) ... part(parts - 1) on the calling thread and those of the step that have nothing else to do; returns
  /// when all are done, throws the first exception of a part.
  virtual void share(std::size_t parts, const std::function<void(std::size_t)>& part) = 0;
};

/// The costly pairs of a batch, moved to its front: the first `all` may cost far more than the others, and of these the
/// first `costliest` will take the longest of all.
struct HeavyPairs {
  std::size_t costliest = 0, all = 0;
};

/// The work of one step, described once for all executors. Its stages have independent blocks: the first stage turns
/// poses into boxes, the last emits candidate pairs, those between prepare the broad phase. Within a stage blocks run
/// in any order on any thread; a stage starts when the one before it is done. Batches of emitted pairs may go to
/// `narrow` while the last stage still runs.
class StepWork {
 public:
  virtual ~StepWork() = default;

  /// Starts a step; returns the number of stages, at least 2.
  virtual std::size_t begin() = 0;
  /// Sets the threads that `narrow` may ask for help until the step ends; null: the caller is alone. Before begin().
  virtual void work_with(Crew*) {}
  /// Sets a function that tells, until the step ends, whether its rest is not wanted any more: stopped, cancelled or
  /// failed. Long work within a batch may call it, from any thread, and then leave its answers as they are. Before
  /// begin().
  virtual void ended_by(std::function<bool()>) {}
  /// The number of a stage's blocks; asked for once the stages before it are done.
  virtual std::size_t blocks(std::size_t stage) const = 0;
  virtual void run(std::size_t stage, std::size_t block) = 0;
  virtual void emit(std::size_t block, PairSink& sink) = 0;

  virtual const PairFilter& filter() const = 0;
  /// Applies the user's predicate to a batch of candidates; see PairPredicate.
  virtual std::size_t keep(std::span<Pair> pairs) const = 0;
  /// Moves the pairs that may cost far more than the others to the front, the costliest first, and returns how many
  /// there are. They travel in small batches of their own and are narrowed first, so that none is left for the end.
  /// `batch`: the time that a batch should take; a pair that takes less is not among the costliest, since it can travel
  /// with others.
  virtual HeavyPairs heavy_first(std::span<Pair>, std::chrono::nanoseconds /*batch*/) const { return {}; }
  /// Tells how long the narrow phase of a batch with heavy pairs took, as an estimate for the next step. From many
  /// threads at once.
  virtual void took(const Batch&, std::chrono::nanoseconds) const {}
  /// Computes the batch's results from its pairs. From many threads at once, on different batches.
  virtual void narrow(Batch& batch) const = 0;
  /// One past the largest body index.
  virtual std::size_t bodies() const = 0;
};

}  // namespace tandem
