#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/flowgraph/timeline.h"

namespace tandem::bench {

/// What every piece of work of one step cost on one thread (ns), in the order in which a single thread does them.
struct RecordedStep {
  using Blocks = std::vector<double>;
  struct Tile {
    double ns = 0;
    std::uint64_t pairs = 0;  ///< emitted
  };

  double begin_ns = 0;         ///< before the first stage, on the caller
  std::vector<Blocks> before;  ///< stages up to the shared one: boxes, then the broad phase's preparation
  std::vector<Tile> tiles;     ///< of the shared stage
  std::vector<Blocks> after;   ///< the joiner's stages

  /// Narrow phase of the pairs [first, end) in the tiles' order; known by batches, spread evenly within each.
  double narrow_ns(double first, double end) const { return narrow_until(end) - narrow_until(first); }
  double work_ns() const;
  std::size_t tasks() const;
  std::uint64_t pairs() const { return pair_marks_.empty() ? 0 : pair_marks_.back(); }

  friend RecordedStep read_step(const std::vector<Timeline::Slice>& slices);
  friend RecordedStep typical(std::vector<RecordedStep> runs);

 private:
  double narrow_until(double pair) const;
  std::vector<double*> pieces();

  std::vector<std::uint64_t> pair_marks_;  // pairs done after each batch
  std::vector<double> batch_ns_, narrow_marks_;
};

/// From the slices of one step of the sequential executor.
RecordedStep read_step(const std::vector<Timeline::Slice>& slices);

/// The median time of every piece over several runs of one step: what disturbs a run hits other pieces each time.
RecordedStep typical(std::vector<RecordedStep> runs);

}  // namespace tandem::bench
