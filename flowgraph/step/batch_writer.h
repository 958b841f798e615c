#pragma once
#include <cstddef>
#include <cstdint>

#include "answers/ordered_answers.h"
#include "tandem/broadphase/pair.h"
#include "tandem/flowgraph/batch.h"
#include "tandem/flowgraph/options.h"
#include "tandem/flowgraph/step_work.h"

namespace tandem {

/// The step that batches belong to.
class BatchOwner {
 public:
  virtual ~BatchOwner() = default;
  virtual StepWork& work() = 0;
  virtual StepForm form() const = 0;
  virtual BatchPairs batch_pairs() const = 0;

  /// Keeps the shared stage open until close_work(); may throw.
  virtual Batch& open_batch() = 0;
  /// A batch is done, or nobody has it.
  virtual void close_work() = 0;
  virtual void count_candidates(std::size_t pairs) = 0;
  /// Some pair costs far more than others.
  virtual void saw_heavy() = 0;

  /// Whether the rest of the step is only counted off.
  virtual bool failed() const = 0;
  /// Notes the exception being handled, if it is the first.
  virtual void capture() noexcept = 0;
};

/// Where a filled batch goes; what differs between executors.
class Delivery {
 public:
  virtual ~Delivery() = default;
  virtual void deliver(Batch& batch) = 0;
};

/// One thread's end of the broad phase: fills a batch, over several tiles if need be, and hands it on when full.
class BatchWriter final : public PairSink {
 public:
  BatchWriter(BatchOwner& step, Delivery& delivery) : step_(step), delivery_(delivery) {}
  BatchWriter(const BatchWriter&) = delete;
  BatchWriter& operator=(const BatchWriter&) = delete;

  /// Ready to take pairs. The batch in hand keeps the stage open until it is delivered and processed, or dropped.
  void open();
  /// Hands on what is there; a no-op with nothing in hand.
  void flush();
  /// Forgets the pairs in hand.
  void drop();
  /// Candidates put so far.
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
