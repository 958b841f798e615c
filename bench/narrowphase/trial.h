#pragma once
#include <csetjmp>
#include <csignal>
#include <functional>
#include <vector>

namespace tandem::bench {

/// Which of the queries 0..n-1 end the process (an assertion, a bad access) or take more than 10 ms: nonzero. They are
/// tried in child processes, silently. Call it while no other thread holds a lock that `query` needs.
std::vector<char> deadly_queries(std::size_t n, const std::function<void(std::size_t)>& query);

/// While it lives, an abort() within `attempt` on this thread ends that attempt instead of the process: some libraries
/// abort at addresses' whim, at queries that a trial survived. What the attempt held is not released. One at a time.
class AbortTrap {
 public:
  AbortTrap();
  ~AbortTrap();
  AbortTrap(const AbortTrap&) = delete;
  AbortTrap& operator=(const AbortTrap&) = delete;
};

/// Where an abort goes, if it is caught: a signal handler knows no other way.
extern thread_local std::sig_atomic_t abort_is_caught;
extern thread_local sigjmp_buf abort_target;

/// False if it aborted, with an AbortTrap alive.
template <typename Work>
bool attempt(const Work& work) {
  if (sigsetjmp(abort_target, 0) != 0) return false;
  abort_is_caught = 1;
  work();
  abort_is_caught = 0;
  return true;
}

}  // namespace tandem::bench
