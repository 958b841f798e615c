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

/// Where a step's answers go, by its form, and the stages that follow the tiles. Overlapped: batches are answered while
/// there are tiles, each thread's answers into a store, and joined by stages at last. Ordered: stages put the pairs in
/// order, narrow them in runs of batches, and copy the answers that are not in their places yet. On the caller alone:
/// the pairs are put in order at once, the answers go straight to the list, and no stage follows.
class AnswerStages {
 public:
  void begin(StepWork& work, StepForm form, BatchPairs batch_pairs, ContactList& contacts);
  StepForm form() const { return form_; }

  std::size_t stages() const;
  /// The stage whose blocks are runs of batches to narrow, or stages() if they are narrowed before.
  std::size_t narrow_stage() const { return form_ == StepForm::ordered ? PairOrder::stages : stages(); }
  /// What is serial before a stage, `batches` being all of the step; returns its blocks.
  std::size_t open(std::size_t stage, std::span<Batch* const> batches);
  /// A block of a stage other than the narrow stage.
  void run(std::size_t stage, std::size_t block);

  /// Narrows a batch, its answers going where they belong. Any thread; on the caller alone in the batches' order.
  void narrow(Batch& batch);
  /// On the caller alone, before the first batch is narrowed.
  void sort(std::span<Batch* const> batches);
  /// Some pair costs far more than others: narrow it first. Any thread, before the narrow stage.
  void saw_heavy() { has_heavy_.store(true, std::memory_order_relaxed); }
  /// The runs of the narrow stage.
  OrderedAnswers& runs() { return runs_; }

  std::size_t memory() const { return store_.memory() + joiner_.memory() + order_.memory() + runs_.memory(); }

  /// Forgets all answers.
  void clear();

 private:
  StepWork* work_ = nullptr;
  ContactList* contacts_ = nullptr;
  StepForm form_ = StepForm::caller;
  BatchPairs batch_pairs_{0};
  AnswerStore store_;
  Joiner joiner_;
  PairOrder order_;
  OrderedAnswers runs_;
  std::atomic<bool> has_heavy_{false};
};

}  // namespace tandem
