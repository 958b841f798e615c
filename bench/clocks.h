// Clocks of the benches, in nanoseconds.
#pragma once
#include <time.h>

#include <chrono>

namespace tandem::bench {

inline double clock_ns(clockid_t clock) {
  timespec now{};
  clock_gettime(clock, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

/// Processor time of the calling thread, which other processes disturb less than wall time.
inline double cpu_ns() { return clock_ns(CLOCK_THREAD_CPUTIME_ID); }
/// Processor time of all threads of the process.
inline double process_cpu_ns() { return clock_ns(CLOCK_PROCESS_CPUTIME_ID); }
inline double wall_ns() { return clock_ns(CLOCK_MONOTONIC); }

/// Keeps the calling thread busy for so long.
inline void stay_busy(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) {
  }
}

}  // namespace tandem::bench
