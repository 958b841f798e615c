// Fills batches with the candidates of tiles and hands them on.
#include "step/batch_writer.h"

#include <algorithm>
#include <utility>

namespace tandem {

void BatchWriter::open() {
  if (batch_ != nullptr) return;
  batch_ = &step_.open_batch();
  filter_ = &step_.work().filter();
  buffer_ = batch_->pairs.data();
  capacity_ = step_.batch_pairs().most;
  count_ = 0;
}

void BatchWriter::hand_on() {
  step_.count_candidates(count_);
  handed_on_ += count_;
  Batch& batch = *std::exchange(batch_, nullptr);
  const std::size_t count = std::exchange(count_, 0);
  try {
    batch.count = step_.work().keep({buffer_, count});
    // A batch of an ordered step stays in the pool until the pairs are sorted.
    if (step_.form() == StepForm::ordered) {
      const auto pairs = std::span(batch.pairs).first(batch.count);
      if (step_.work().heavy_first(pairs, step_.batch_pairs().time).all != 0) step_.saw_heavy();
      return step_.close_work();
    }
    if (step_.form() == StepForm::overlapped && step_.batch_pairs().heavy != 0) split_off_heavy(batch);
  } catch (...) {
    step_.close_work();  // Nobody has the batch.
    throw;
  }
  if (batch.count == 0) return step_.close_work();
  deliver(batch);
}

void BatchWriter::deliver(Batch& batch) {
  try {
    delivery_.deliver(batch);
  } catch (...) {
    step_.close_work();
    throw;
  }
}

void BatchWriter::split_off_heavy(Batch& batch) {
  const std::span<Pair> pairs = std::span(batch.pairs).first(batch.count);
  const auto [costliest, heavy] = step_.work().heavy_first(pairs, step_.batch_pairs().time);
  if (costliest == 0 && heavy == pairs.size() && heavy <= step_.batch_pairs().heavy) {
    batch.heavy = true;
    return;
  }
  for (std::size_t first = 0, count = 0; first < heavy; first += count) {
    // The costliest pairs travel one by one: they are begun first, so that the step does not end with a long batch.
    count = first < costliest ? 1 : std::min(step_.batch_pairs().heavy, heavy - first);
    const std::span<const Pair> own = pairs.subspan(first, count);
    Batch& other = step_.open_batch();
    std::copy(own.begin(), own.end(), other.pairs.begin());
    other.count = own.size();
    other.heavy = true;
    other.costliest = first < costliest;
    deliver(other);
  }
  std::copy(pairs.begin() + static_cast<std::ptrdiff_t>(heavy), pairs.end(), pairs.begin());
  batch.count -= heavy;
}

void BatchWriter::full() {
  hand_on();
  open();
}

void BatchWriter::flush() {
  if (batch_ == nullptr) return;
  if (step_.failed()) return drop();
  try {
    hand_on();
  } catch (...) {
    step_.capture();
    drop();
  }
}

void BatchWriter::drop() {
  if (std::exchange(batch_, nullptr) == nullptr) return;
  count_ = 0;
  step_.close_work();
}

}  // namespace tandem
