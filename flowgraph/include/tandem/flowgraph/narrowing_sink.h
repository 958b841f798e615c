// A sink that solves the pairs of tiles in batches, for user-defined executors.
#pragma once
#include <cstddef>
#include <cstdint>

#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/batch.h"
#include "tandem/flowgraph/joiner.h"
#include "tandem/flowgraph/step_work.h"

namespace tandem {

/// The sink that a thread of your own executor gives to StepWork::emit: takes the candidates of tiles, narrows each
/// batch of them as soon as it is full, and keeps the answers for a Joiner. One for each thread, made when the step has
/// begun.
class NarrowingSink final : public PairSink {
 public:
  /// `pairs`: size of a batch, at least 1, else std::invalid_argument. `work` must outlive the sink.
  explicit NarrowingSink(StepWork& work, std::size_t pairs = 128);
  NarrowingSink(const NarrowingSink&) = delete;
  NarrowingSink& operator=(const NarrowingSink&) = delete;

  /// Narrows the pairs that are left of the tiles so far.
  void flush();
  /// The answers so far.
  AnswerChunk& answers() { return answers_; }
  /// The number of pairs that were put and passed the filter.
  std::uint64_t candidates() const { return narrowed_ + count_; }
  bool inexact() const { return batch_.inexact; }  ///< some answer did not reach the tolerance

 private:
  void full() override { flush(); }

  StepWork& work_;
  Batch batch_;
  AnswerChunk answers_;
  std::uint64_t narrowed_ = 0;
};

}  // namespace tandem
