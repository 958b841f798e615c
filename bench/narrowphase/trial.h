// Guards against queries at which a library aborts, crashes or hangs.
#pragma once
#include <csetjmp>
#include <csignal>
#include <functional>
#include <vector>

namespace tandem::bench {

/// Marks, nonzero, the queries of 0..n-1 that end the process (an assertion, a bad access) or take more than 10 ms.
/// They are tried in child processes, silently. To be called while no other thread holds a lock that `query` needs.
std::vector<char> deadly_queries(std::size_t n, const std::function<void(std::size_t)>& query);

/// While it lives, an abort() within `attempt` on this thread ends that attempt instead of the process: some libraries
/// abort, depending on addresses, at queries that passed a trial. Resources of the attempt are not released. One trap
/// at a time.
class AbortTrap {
 public:
  AbortTrap();
  ~AbortTrap();
  AbortTrap(const AbortTrap&) = delete;
  AbortTrap& operator=(const AbortTrap&) = delete;
};

/// Set while aborts are caught: a signal handler has no other input.
extern thread_local std::sig_atomic_t abort_is_caught;
extern thread_local sigjmp_buf abort_target;

/// Runs the work; false if it aborted, with an AbortTrap alive.
template <typename Work>
bool attempt(const Work& work) {
  if (sigsetjmp(abort_target, 0) != 0) return false;
  abort_is_caught = 1;
  work();
  abort_is_caught = 0;
  return true;
}

}  // namespace tandem::bench
