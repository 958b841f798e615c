#include "shapes/build_meter.h"

#include <algorithm>

namespace tandem {

void BuildMeter::spend(std::size_t work) {
  if (options_.limit != nullptr && options_.limit->reached()) throw WorkStopped();
  const std::size_t before = done_.fetch_add(work, std::memory_order_relaxed), now = before + work;
  // The last time is kept for the end.
  if (options_.progress && now * times / work_ > before * times / work_) tell(std::min(now, work_ - 1));
}

void BuildMeter::finish() {
  if (options_.progress) tell(work_);
}

// Threads come here in any order: who comes late, or while another one tells, has nothing to tell. Nobody waits: a
// user's function that waits for tasks may come to run one of these passes itself.
void BuildMeter::tell(std::size_t done) {
  if (telling_.exchange(true, std::memory_order_acquire)) return;
  if (done > told_) {
    told_ = done;
    options_.progress(static_cast<double>(done) / static_cast<double>(work_));
  }
  telling_.store(false, std::memory_order_release);
}

}  // namespace tandem
