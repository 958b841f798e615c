// Stages that follow the tiles, by the form of the step: join the answers, or sort the pairs, narrow and copy.
#include "step/answer_stages.h"

#include <algorithm>
#include <functional>

#include "step/lent_lists.h"

namespace tandem {

void AnswerStages::begin(StepWork& work, StepForm form, BatchPairs batch_pairs, ContactList& contacts) {
  work_ = &work;
  contacts_ = &contacts;
  form_ = form;
  batch_pairs_ = batch_pairs;
  has_heavy_.store(false, std::memory_order_relaxed);
  if (form == StepForm::caller) clear();  // without tiles no thread comes to write
  if (form == StepForm::overlapped) {
    store_.begin();
    joiner_.begin(work.bodies(), contacts);
  }
}

std::size_t AnswerStages::stages() const {
  if (form_ == StepForm::overlapped) return Joiner::stages;
  return form_ == StepForm::ordered ? PairOrder::stages + 2 : 0;
}

std::size_t AnswerStages::open(std::size_t stage, std::span<Batch* const> batches) {
  if (form_ == StepForm::overlapped) {
    if (stage == 0) joiner_.take(store_.taken());
    return joiner_.blocks(stage);
  }
  if (stage == 0) order_.begin(batches, work_->bodies());
  if (stage < PairOrder::stages) return order_.open(stage);
  if (stage > narrow_stage()) return runs_.open_rest();
  std::function<bool(Pair)> is_heavy;
  if (has_heavy_.load(std::memory_order_relaxed))
    is_heavy = [this](Pair pair) { return work_->heavy_first({&pair, 1}, batch_pairs_.time).all != 0; };
  runs_.begin(order_.sorted(), batch_pairs_, is_heavy, *contacts_);
  return runs_.runs();
}

void AnswerStages::run(std::size_t stage, std::size_t block) {
  if (form_ == StepForm::overlapped)
    joiner_.run(stage, block);
  else if (stage < PairOrder::stages)
    order_.run(stage, block);
  else
    runs_.copy_rest(block);
}

void AnswerStages::narrow(Batch& batch) {
  if (form_ == StepForm::ordered) return work_->narrow(batch);
  if (form_ == StepForm::caller) {
    take_sorted(batch);
    const LentLists to_list(batch, contacts_->pairs, contacts_->contacts);
    return work_->narrow(batch);
  }
  AnswerChunk& own = store_.room(batch.count);
  const std::size_t before = own.results.size();
  {
    const LentLists to_chunk(batch, own.results, own.contacts);
    work_->narrow(batch);
  }
  joiner_.count(std::span(own.results).subspan(before));
}

void AnswerStages::sort(std::span<Batch* const> batches) {
  order_.sort(batches, work_->bodies());
  next_sorted_ = 0;
}

void AnswerStages::take_sorted(Batch& batch) {
  const auto left = order_.sorted().subspan(next_sorted_);
  const auto keys = left.first(std::min(left.size(), batch_pairs_.most));
  std::transform(keys.begin(), keys.end(), batch.pairs.begin(), pair_of);
  batch.count = keys.size();
  next_sorted_ += keys.size();
}

void AnswerStages::clear() {
  contacts_->pairs.clear();
  contacts_->contacts.clear();
}

}  // namespace tandem
