#pragma once
#include <algorithm>
#include <functional>
#include <memory>

#include "measurement/balancer.h"
#include "step/step_form.h"
#include "step/step_state.h"
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

/// Chooses the batch size by the last step's cost of a pair: 15 us of narrow work, up to 120 in long steps, at most
/// what the user allows. On the caller alone, where none is handed on, that is what they hold.
class BatchSize {
 public:
  explicit BatchSize(std::size_t most) : most_(most), size_{.most = most, .heavy = 1} {}
  BatchPairs get(StepForm form) const { return form == StepForm::caller ? BatchPairs{.most = most_} : size_; }
  void learn(const ExecutionReport& report);

 private:
  std::size_t most_;
  BatchPairs size_;
};

/// Batches that may wait. A producer that finds the queue full narrows a batch, and the tile in its hand waits: the
/// more threads there are, the more of them may do that at once and leave the costly pairs of their tiles for the end.
inline std::size_t usual_queue_capacity(int threads) {
  const auto count = static_cast<std::size_t>(threads);
  return std::clamp(4 * count * count, std::size_t{16}, std::size_t{1} << 20);
}

/// What a step's time goes with.
inline double load_of(const StepWork& work, const ExecutionReport& report) {
  return static_cast<double>(work.bodies() + report.candidate_pairs);
}

/// Balances after a step and writes what it decided into the report and the timeline.
void balance(Balancer& balancer, std::uint64_t step, ExecutionReport& report, Timeline* timeline);

}  // namespace tandem
