#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>

#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

/// The methods; `automatic` picks one by the boxes and keeps its candidates between steps. The others keep nothing.
/// `own`: a method of one's own, which make_broad_phase does not know.
enum class BroadPhaseKind : std::uint8_t { brute, sweep, grid, bvh, automatic, own };

std::string_view name(BroadPhaseKind kind);

/// Boxes in, pairs out each step: every pair whose boxes overlap, each exactly once, whatever the steps before were.
/// One of one's own derives from this (examples/own_broad_phase.cpp).
///
/// A method is a short list of stages. A stage is a number of blocks that may run in any order and on any threads;
/// stage s + 1 starts when all blocks of stage s are done. The last stage emits pairs. Nothing here knows a
/// scheduler: an executor drives it, and the set of pairs does not depend on how.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  /// What the sinks of the steps that follow filter by, and no other: what a method keeps by it need not be filtered
  /// again (PairSink::put_allowed). The arrays must outlive those steps; what is in them may change between steps.
  virtual void expect(const PairFilter&) {}
  /// What the next step, and only that, may have changed since the step before: one byte a box, 0 where the box and its
  /// part of the filter are the same bits. Only for speed: a method that keeps candidates then does not look at these,
  /// so that what stands still costs nothing. The array must outlive the step and may still be written until its
  /// stage 0 runs. A byte that is wrongly 0 loses pairs (asserted in debug builds).
  virtual void expect_changes(std::span<const std::uint8_t>) {}
  /// In the next step, and only that, pairs of two boxes that have not changed may be left out. Only for speed: a sink
  /// may be given them all the same.
  virtual void expect_only_changes() {}
  /// Starts a step. `boxes` must outlive it; its bounds may still be written until stage 0 runs, its size is fixed.
  /// Returns the number of stages, at least 1. Not thread-safe, like all but `run` and `emit`.
  virtual std::size_t begin(const BoxArray& boxes) = 0;
  /// Blocks of a stage; known once the stages before it are done. Zero is possible.
  virtual std::size_t blocks(std::size_t stage) const = 0;
  /// Runs one block of a stage that is not the last.
  virtual void run(std::size_t /*stage*/, std::size_t /*block*/) {}
  /// Runs one block of the last stage. Calls `sink.put` from the calling thread only.
  virtual void emit(std::size_t block, PairSink& sink) = 0;

  /// The method at work in this step: differs from what was asked for only with `automatic`. The text says why.
  virtual BroadPhaseKind kind() const { return BroadPhaseKind::own; }
  virtual std::string_view reason() const { return {}; }
  /// Bytes held between steps, the boxes and the pairs not counted.
  virtual std::size_t memory() const { return 0; }
};

/// Makes a broad phase of one's own.
using BroadPhaseFactory = std::function<std::unique_ptr<BroadPhase>()>;

std::unique_ptr<BroadPhase> make_broad_phase(BroadPhaseKind kind);

/// All pairs of a broad phase on the calling thread, sorted. For tests and small uses: those of a method of one's own
/// must be those of BroadPhaseKind::brute.
std::vector<Pair> find_pairs(BroadPhase& method, const BoxArray& boxes, const PairFilter& filter = {});

}  // namespace tandem
