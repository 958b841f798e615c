// Counts work until the next check of a limit.
#include "shapes/work_meter.h"

namespace tandem {

bool WorkLimit::reached() const {
  using Clock = std::chrono::steady_clock;
  return stop.stop_requested() || (deadline != Clock::time_point::max() && Clock::now() >= deadline) ||
         (ended && ended());
}

void WorkMeter::check_limit() {
  // A stop may come a little after a deadline, and all steps may have one: check less often then.
  const bool has_deadline = limit_ != nullptr && limit_->deadline != std::chrono::steady_clock::time_point::max();
  left_ = has_deadline ? between : 4 * between;
  if (limit_ != nullptr && limit_->reached()) throw WorkStopped();
}

}  // namespace tandem
