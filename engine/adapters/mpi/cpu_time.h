// CPU time of a thread.
#pragma once
#include <ctime>

namespace tandem::mpi {

/// CPU time of the calling thread, which does not include the time of other programs on the same core.
inline double cpu_ms() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  constexpr double ms_a_s = 1e3, ns_a_ms = 1e6;
  return ms_a_s * static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) / ns_a_ms;
}

}  // namespace tandem::mpi
