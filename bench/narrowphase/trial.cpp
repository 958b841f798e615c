// Finds the queries at which a library aborts or hangs.
#include "trial.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <new>
#include <system_error>

namespace tandem::bench {
namespace {

/// The number of the current query, seen by both processes.
class SharedCounter {
 public:
  SharedCounter() : page_(::mmap(nullptr, sizeof(Counter), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) {
    if (page_ == MAP_FAILED) throw std::system_error(errno, std::generic_category(), "mmap");
    counter_ = new (page_) Counter(0);
  }
  ~SharedCounter() { ::munmap(page_, sizeof(Counter)); }
  SharedCounter(const SharedCounter&) = delete;
  SharedCounter& operator=(const SharedCounter&) = delete;
  auto& operator*() { return *counter_; }

 private:
  using Counter = std::atomic<std::size_t>;
  void* page_;
  Counter* counter_;
};

void leave_attempt(int) {
  if (abort_is_caught == 0) return;  // abort() then ends the process
  abort_is_caught = 0;
  siglongjmp(abort_target, 1);
}

[[noreturn]] void try_from(std::size_t first, std::size_t n, const std::function<void(std::size_t)>& query,
                           std::atomic<std::size_t>& at) {
  const int nowhere = ::open("/dev/null", O_WRONLY);
  ::dup2(nowhere, STDERR_FILENO);
  ::dup2(nowhere, STDOUT_FILENO);
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  for (std::size_t i = first; i < n; ++i) {
    at = i;
    const itimerval limit{{0, 0}, {0, 10'000}};
    ::setitimer(ITIMER_PROF, &limit, nullptr);
    query(i);
  }
  ::_exit(0);
}

}  // namespace

thread_local std::sig_atomic_t abort_is_caught = 0;
thread_local sigjmp_buf abort_target;

AbortTrap::AbortTrap() {
  struct sigaction action {};
  action.sa_handler = leave_attempt;
  action.sa_flags = SA_NODEFER;  // the handler is left by a jump, with the signal mask unchanged
  ::sigaction(SIGABRT, &action, nullptr);
}

AbortTrap::~AbortTrap() { std::signal(SIGABRT, SIG_DFL); }

std::vector<char> deadly_queries(std::size_t n, const std::function<void(std::size_t)>& query) {
  std::vector<char> deadly(n, 0);
  SharedCounter at;
  for (std::size_t first = 0; first < n; first = *at + 1) {
    const ::pid_t child = ::fork();
    if (child < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (child == 0) try_from(first, n, query, *at);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) break;
    deadly[*at] = 1;
  }
  return deadly;
}

}  // namespace tandem::bench
