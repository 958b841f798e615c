// Timeouts of Python calls.
#pragma once
#include <algorithm>
#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>

#include "arrays.h"
#include "tandem/narrowphase/work_limit.h"

namespace tandem::python {

/// The end time of a call with a timeout; None: never. Throws std::invalid_argument unless seconds >= 0.
inline std::chrono::steady_clock::time_point deadline_after(std::optional<double> timeout) {
  using Clock = std::chrono::steady_clock;
  if (!timeout) return Clock::time_point::max();
  if (!(*timeout >= 0))
    throw std::invalid_argument("timeout: " + written(*timeout) + ", allowed: seconds >= 0, or None");
  const std::chrono::duration<double> most = std::chrono::hours(24 * 365);  // a longer time would overflow the clock
  const std::chrono::duration<double> seconds = std::min(std::chrono::duration<double>(*timeout), most);
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(seconds);
}

inline WorkLimit limit_after(std::optional<double> timeout) { return {.deadline = deadline_after(timeout)}; }

}  // namespace tandem::python
