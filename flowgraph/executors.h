#pragma once
#include <functional>
#include <memory>

#include "step_state.h"
#include "tandem/flowgraph/balancer.h"
#include "tandem/flowgraph/executor.h"

namespace tandem {

std::unique_ptr<Executor> make_sequential_executor(const ExecutorOptions& options);
std::unique_ptr<Executor> make_loop_executor(const ExecutorOptions& options);
std::unique_ptr<Executor> make_threads_executor(const ExecutorOptions& options);
std::unique_ptr<Executor> make_flowgraph_executor(const ExecutorOptions& options);

/// Threads that oneTBB may give to the caller: the wish (0: the arena it is in), capped by the process's limit.
int tbb_threads(int wished);

/// Asks whether the task group that the calling task belongs to has been cancelled; valid while that task runs.
std::function<bool()> host_cancellation();

/// Chooses the batch size by the last step's cost of a pair: 15 us of narrow work, up to 60 in long steps, at most what
/// the user allows.
class BatchSize {
 public:
  explicit BatchSize(std::size_t most) : most_(most), size_{most, 1} {}
  BatchPairs get() const { return size_; }
  void learn(const ExecutionReport& report);

 private:
  std::size_t most_;
  BatchPairs size_;
};

/// Tells whether a step is worth sharing: decided from the work of the steps before it.
class SmallStep {
 public:
  explicit SmallStep(double limit_ms) : limit_ms_(limit_ms) {}
  bool stays_on_caller() const { return work_ms_ < limit_ms_; }
  void learn(double work_ms) { work_ms_ = work_ms; }

 private:
  double limit_ms_;
  double work_ms_ = 1e300;  // the first step is shared
};

/// Balances after a step and writes what it decided into the report and the timeline.
void balance(Balancer& balancer, std::uint64_t step, ExecutionReport& report, Timeline* timeline);

}  // namespace tandem
