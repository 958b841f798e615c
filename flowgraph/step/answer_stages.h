// The stages of a step after the broad phase, by the form of the step.
#pragma once
#include <atomic>
#include <cstddef>
#include <span>

#include "answers/answer_store.h"
#include "answers/ordered_answers.h"
#include "answers/pair_order.h"
#include "tandem/flowgraph/joiner.h"
#include "tandem/flowgraph/report.h"
#include "tandem/flowgraph/step_work.h"

namespace tandem {

/// The stages that follow the tiles, and where a step's answers go, by the form of the step. Overlapped: batches are
/// answered while there are tiles, each thread's answers go to a store of its own, and stages join them at the end.
/// Ordered: stages sort the pairs, narrow them in runs of batches, and copy the answers that are not in their places
/// yet. On the caller alone: the pairs are sorted at once, the answers go straight to the list, and no stage follows.
class AnswerStages {
 public:
  void begin(StepWork& work, StepForm form, BatchPairs batch_pairs, ContactList& contacts);
  StepForm form() const { return form_; }

  std::size_t stages() const;
  /// The stage whose blocks are runs of batches to narrow, or stages() if pairs are narrowed before.
  std::size_t narrow_stage() const { return form_ == StepForm::ordered ? PairOrder::stages : stages(); }
  /// The serial work before a stage, given all batches of the step; returns the number of its blocks.
  std::size_t open(std::size_t stage, std::span<Batch* const> batches);
  /// Runs a block of a stage other than the narrow stage.
  void run(std::size_t stage, std::size_t block);

  /// Narrows a batch and puts its answers where they belong. Any thread; on the caller alone in the batches' order.
  void narrow(Batch& batch);
  /// Sorts the pairs of all batches; on the caller alone, before the first batch is narrowed.
  void sort(std::span<Batch* const> batches);
  /// The number of sorted pairs that are not narrowed yet; on the caller alone.
  std::size_t sorted_left() const { return order_.sorted().size() - next_sorted_; }
  /// Notes that some pair costs far more than others, so that it is narrowed first. Any thread, before the narrow
  /// stage.
  void saw_heavy() { has_heavy_.store(true, std::memory_order_relaxed); }
  /// The runs of the narrow stage.
  OrderedAnswers& runs() { return runs_; }

  std::size_t memory() const { return store_.memory() + joiner_.memory() + order_.memory() + runs_.memory(); }

  /// Forgets all answers.
  void clear();

 private:
  /// Fills a batch with the next of the sorted pairs: to its capacity, as filtering has left room in the batches.
  void take_sorted(Batch& batch);

  StepWork* work_ = nullptr;
  ContactList* contacts_ = nullptr;
  StepForm form_ = StepForm::caller;
  BatchPairs batch_pairs_{0};
  AnswerStore store_;
  Joiner joiner_;
  PairOrder order_;
  OrderedAnswers runs_;
  std::size_t next_sorted_ = 0;  // the next sorted pair to narrow on the caller alone
  std::atomic<bool> has_heavy_{false};
};

}  // namespace tandem
