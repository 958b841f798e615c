// Narrows the pairs of tiles batch by batch, for executors of users.
#include "tandem/flowgraph/narrowing_sink.h"

#include <stdexcept>
#include <utility>

namespace tandem {

NarrowingSink::NarrowingSink(StepWork& work, std::size_t pairs) : work_(work) {
  if (pairs == 0) throw std::invalid_argument("NarrowingSink: pairs: 0, allowed: at least 1");
  batch_.clear(pairs);
  filter_ = &work.filter();
  buffer_ = batch_.pairs.data();
  capacity_ = pairs;
}

void NarrowingSink::flush() {
  const std::size_t count = std::exchange(count_, 0);
  narrowed_ += count;
  batch_.count = work_.keep({buffer_, count});
  if (batch_.count == 0) return;
  // A batch appends to its own lists, so the lists of all earlier batches are lent to it meanwhile.
  const auto exchange = [this] {
    batch_.results.swap(answers_.results);
    batch_.contacts.swap(answers_.contacts);
  };
  exchange();
  try {
    work_.narrow(batch_);
  } catch (...) {
    exchange();
    throw;
  }
  exchange();
  ++batch_.id;
}

}  // namespace tandem
