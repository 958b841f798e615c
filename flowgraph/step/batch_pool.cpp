// The batches of a step, reused from step to step.
#include "step/batch_pool.h"

#include <algorithm>
#include <iterator>

namespace tandem {

void BatchPool::begin(std::size_t batch_pairs) {
  std::move(grown_.begin(), grown_.end(), std::back_inserter(batches_));
  if (!grown_.empty())  // Some to spare: with a rising load the pool would otherwise grow at every step.
    for (std::size_t more = batches_.size() / 2 + 8; more > 0; --more) batches_.push_back(std::make_unique<Batch>());
  grown_.clear();
  batch_pairs_ = batch_pairs;
  next_.store(0, std::memory_order_relaxed);
}

Batch& BatchPool::take() {
  const std::size_t index = next_.fetch_add(1, std::memory_order_relaxed);
  Batch* batch = nullptr;
  if (index < batches_.size()) {
    batch = batches_[index].get();
  } else {
    const std::scoped_lock lock(mutex_);
    batch = grown_.emplace_back(std::make_unique<Batch>()).get();
  }
  batch->clear(batch_pairs_);
  batch->id = index;
  return *batch;
}

std::span<Batch* const> BatchPool::taken() {
  taken_.clear();
  const std::size_t old = std::min(next_.load(std::memory_order_relaxed), batches_.size());
  for (std::size_t i = 0; i < old; ++i) taken_.push_back(batches_[i].get());
  for (const auto& batch : grown_) taken_.push_back(batch.get());
  return taken_;
}

std::size_t BatchPool::memory() const {
  std::size_t bytes = taken_.capacity() * sizeof(Batch*);
  for (const auto* list : {&batches_, &grown_})
    for (const auto& batch : *list) bytes += sizeof(Batch) + batch->memory();
  return bytes;
}

}  // namespace tandem
