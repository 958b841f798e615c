#pragma once
#include <cstddef>
#include <cstdint>

#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/batch.h"
#include "tandem/flowgraph/joiner.h"
#include "tandem/flowgraph/step_work.h"

namespace tandem {

/// What a thread of an executor of one's own gives to StepWork::emit: takes the candidates of tiles, narrows each batch
/// of them as soon as it is full, and keeps the answers for a Joiner. One a thread; made when the step has begun.
class NarrowingSink final : public PairSink {
 public:
  /// `pairs`: of a batch, at least 1, else std::invalid_argument. `work` must outlive it.
  explicit NarrowingSink(StepWork& work, std::size_t pairs = 128);
  NarrowingSink(const NarrowingSink&) = delete;
  NarrowingSink& operator=(const NarrowingSink&) = delete;

  /// Narrows what is left of the tiles so far.
  void flush();
  /// What was narrowed so far.
  AnswerChunk& answers() { return answers_; }
  /// How many were put and not filtered.
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
