// Progress and limit of the building of a mesh.
#include "shapes/build_meter.h"

#include <algorithm>

namespace tandem {

void BuildMeter::spend(std::size_t work) {
  if (options_.limit != nullptr && options_.limit->reached()) throw WorkStopped();
  const std::size_t before = done_.fetch_add(work, std::memory_order_relaxed), now = before + work;
  // The last report is made by finish().
  if (options_.progress && now * times / work_ > before * times / work_) report_progress(std::min(now, work_ - 1));
}

void BuildMeter::finish() {
  if (options_.progress) report_progress(work_);
}

// Threads come here in any order: a thread that is late, or comes while another one reports, reports nothing. No thread
// waits: a user's function that waits for tasks may be given one of these passes itself.
void BuildMeter::report_progress(std::size_t done) {
  if (telling_.exchange(true, std::memory_order_acquire)) return;
  if (done > reported_) {
    reported_ = done;
    options_.progress(static_cast<double>(done) / static_cast<double>(work_));
  }
  telling_.store(false, std::memory_order_release);
}

}  // namespace tandem
