#include "shapes/work_meter.h"

namespace tandem {

bool WorkLimit::reached() const {
  using Clock = std::chrono::steady_clock;
  return stop.stop_requested() || (deadline != Clock::time_point::max() && Clock::now() >= deadline) ||
         (ended && ended());
}

void WorkMeter::check_limit() {
  left_ = between;
  if (limit_ != nullptr && limit_->reached()) throw WorkStopped();
}

}  // namespace tandem
