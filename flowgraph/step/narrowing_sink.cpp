// Narrows the pairs of tiles batch by batch, for executors of users.
#include "tandem/flowgraph/narrowing_sink.h"

#include <stdexcept>
#include <utility>

#include "step/lent_lists.h"

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
  const LentLists lent(batch_, answers_.results, answers_.contacts);
  work_.narrow(batch_);
  ++batch_.id;
}

}  // namespace tandem
