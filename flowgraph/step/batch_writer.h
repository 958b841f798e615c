// Writes the pairs of tiles to batches.
#pragma once
#include <cstddef>
#include <cstdint>

#include "answers/ordered_answers.h"
#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/batch.h"
#include "tandem/flowgraph/options.h"
#include "tandem/flowgraph/step_work.h"

namespace tandem {

/// The step that batches belong to, as writers see it.
class BatchOwner {
 public:
  virtual ~BatchOwner() = default;
  virtual StepWork& work() = 0;
  virtual StepForm form() const = 0;
  virtual BatchPairs batch_pairs() const = 0;

  /// Keeps the shared stage open until close_work(); may throw.
  virtual Batch& open_batch() = 0;
  /// Counts off a batch that is narrowed or dropped.
  virtual void close_work() = 0;
  virtual void count_candidates(std::size_t pairs) = 0;
  /// Notes that some pair costs far more than others.
  virtual void saw_heavy() = 0;

  /// True if the rest of the step is only counted off, not run.
  virtual bool failed() const = 0;
  /// Keeps the exception being handled, if it is the first of the step.
  virtual void capture() noexcept = 0;
};

/// The destination of a filled batch, which differs between executors.
class Delivery {
 public:
  virtual ~Delivery() = default;
  virtual void deliver(Batch& batch) = 0;
};

/// A thread's output of candidate pairs: fills a batch, over several tiles if need be, and hands it on when full.
class BatchWriter final : public PairSink {
 public:
  BatchWriter(BatchOwner& step, Delivery& delivery) : step_(step), delivery_(delivery) {}
  BatchWriter(const BatchWriter&) = delete;
  BatchWriter& operator=(const BatchWriter&) = delete;

  /// Gets ready to take pairs. The batch in hand keeps the stage open until it is delivered and narrowed, or dropped.
  void open();
  /// Hands on the batch in hand; does nothing without one.
  void flush();
  /// Drops the pairs in hand.
  void drop();
  /// The number of candidates put so far.
  std::uint64_t taken() const { return handed_on_ + count_; }

 private:
  void full() override;
  void hand_on();
  void split_off_heavy(Batch& batch);
  void deliver(Batch& batch);

  BatchOwner& step_;
  Delivery& delivery_;
  Batch* batch_ = nullptr;
  std::uint64_t handed_on_ = 0;
};

}  // namespace tandem
