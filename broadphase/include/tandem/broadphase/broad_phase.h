// The interface of broad phases: boxes in, all overlapping pairs out.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <string_view>

#include "tandem/broadphase/box_array.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

/// The methods. `automatic` picks one by the boxes and keeps its candidates between steps; the others keep nothing.
/// `own`: a user's method, which make_broad_phase does not know.
enum class BroadPhaseKind : std::uint8_t { brute, sweep, grid, bvh, automatic, own };

std::string_view name(BroadPhaseKind kind);

/// The broad phase: boxes in, pairs out in each step, namely every pair whose boxes overlap, each exactly once,
/// whatever earlier steps were. A method of your own derives from this class (examples/own_broad_phase.cpp).
///
/// A method is a short list of stages. A stage is a number of blocks that may run in any order and on any threads;
/// stage s + 1 starts when all blocks of stage s are done. The last stage emits pairs. Nothing here knows a
/// scheduler: an executor drives it, and the set of pairs does not depend on how.
class BroadPhase {
 public:
  virtual ~BroadPhase() = default;

  /// Sets the filter that the sinks of all following steps use, so that a method may apply it to pairs that it keeps;
  /// these need not be filtered again (PairSink::put_allowed). The arrays must outlive those steps; their contents may
  /// change between steps.
  virtual void expect(const PairFilter&) {}
  /// Tells which boxes may have changed since the last step, for the next step only: one byte a box, 0 where the box
  /// and its entries of the filter have the same bits as before. An optimisation: a method that keeps candidates skips
  /// unchanged boxes, so that bodies at rest cost nothing. The array must outlive the step and may still be written
  /// until stage 0 runs. A byte that is wrongly 0 loses pairs (asserted in debug builds).
  virtual void expect_changes(std::span<const std::uint8_t>) {}
  /// Permits the next step, and only that, to leave out pairs of two unchanged boxes. An optimisation: a sink may be
  /// given such pairs all the same.
  virtual void expect_only_changes() {}
  /// Starts a step; returns the number of stages, at least 1. `boxes` must outlive the step; its bounds may still be
  /// written until stage 0 runs, its size is fixed. Not thread-safe, like all functions but `run` and `emit`.
  virtual std::size_t begin(const BoxArray& boxes) = 0;
  /// The number of blocks of a stage; known once the stages before it are done. Zero is possible.
  virtual std::size_t blocks(std::size_t stage) const = 0;
  /// Runs one block of a stage that is not the last.
  virtual void run(std::size_t /*stage*/, std::size_t /*block*/) {}
  /// Runs one block of the last stage. Calls `sink.put` only on the calling thread.
  virtual void emit(std::size_t block, PairSink& sink) = 0;

  /// The method used in this step, which differs from the one asked for only with `automatic`. The text gives the
  /// reason.
  virtual BroadPhaseKind kind() const { return BroadPhaseKind::own; }
  virtual std::string_view reason() const { return {}; }
  /// Bytes held between steps, without the boxes and the pairs.
  virtual std::size_t memory() const { return 0; }
};

/// Makes a user's broad phase.
using BroadPhaseFactory = std::function<std::unique_ptr<BroadPhase>()>;

std::unique_ptr<BroadPhase> make_broad_phase(BroadPhaseKind kind);

/// All pairs of a broad phase, found on the calling thread, sorted. For tests and small uses: the pairs of a method of
/// your own must equal those of BroadPhaseKind::brute.
std::vector<Pair> find_pairs(BroadPhase& method, const BoxArray& boxes, const PairFilter& filter = {});

}  // namespace tandem
