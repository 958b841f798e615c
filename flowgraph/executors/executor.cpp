#include "tandem/flowgraph/executor.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "executors/executors.h"

namespace tandem {
namespace {

void require(bool good, const std::string& message) {
  if (!good) throw std::invalid_argument(message);
}

std::string text(Split split) { return std::to_string(split.broad) + "-" + std::to_string(split.narrow); }

}  // namespace

std::unique_ptr<Executor> make_executor(const ExecutorOptions& options) {
  require(options.threads >= 0 && options.threads <= 1024,
          "threads: " + std::to_string(options.threads) + ", allowed: 0 (ask the runtime) to 1024");
  if (const Split split = options.balance.split; !split.dynamic()) {
    require(split.broad >= 1 && split.narrow >= 1,
            "balance.split: " + text(split) + ", allowed: at least one thread for each phase");
    require(options.threads == 0 || split.broad + split.narrow == options.threads,
            "balance.split: " + text(split) + ", allowed: two numbers that add up to the threads, " +
                std::to_string(options.threads));
    require(split.broad + split.narrow <= 1024,
            "balance.split: " + text(split) + ", allowed: at most 1024 threads in all");
  }
  require(options.batches.pairs >= 1 && options.batches.pairs <= 65536,
          "batches.pairs: " + std::to_string(options.batches.pairs) + ", allowed: 1 to 65536");
  require(
      options.batches.queue_capacity <= 1u << 20,
      "batches.queue_capacity: " + std::to_string(options.batches.queue_capacity) + ", allowed: 0 (chosen) to 1048576");
  require(options.sharing.short_step_ms >= 0 && options.sharing.short_step_ms <= 1e6,
          "sharing.short_step_ms: " + std::to_string(options.sharing.short_step_ms) + ", allowed: 0 (never) to 1e6");
  switch (options.kind) {
    case ExecutorKind::sequential:
      return make_sequential_executor(options);
    case ExecutorKind::barrier:
    case ExecutorKind::fused:
      return make_loop_executor(options);
    case ExecutorKind::threads:
      return make_threads_executor(options);
    case ExecutorKind::flowgraph:
      return make_flowgraph_executor(options);
  }
  throw std::invalid_argument("executor: no such kind");
}

int tbb_threads(int wished) {
  // Counts processors from the affinity mask on first use; asking early keeps a later pinned caller from hiding them.
  tbb::info::default_concurrency();
  const auto limit = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const int most = static_cast<int>(std::min<std::size_t>(limit, 1024));
  return std::max(1, std::min(wished == 0 ? tbb::this_task_arena::max_concurrency() : wished, most));
}

std::function<bool()> host_cancellation() {
  tbb::task_group_context* context = tbb::task::current_context();
  if (context == nullptr) return {};
  return [context] { return context->is_group_execution_cancelled(); };
}

void BatchSize::learn(const ExecutionReport& report) {
  // A batch costs half a microsecond where another thread narrows it than found its pairs: in long steps they are
  // larger, as long as the last of them is a small part of a thread's share.
  constexpr double least_ms = std::chrono::duration<double, std::milli>(shortest_batch).count();
  const double target_ms = std::clamp(report.narrow_ms / (100.0 * report.threads), least_ms, 8 * least_ms);
  size_.threads = static_cast<std::size_t>(report.threads);
  size_.time = std::chrono::nanoseconds(static_cast<std::int64_t>(1e6 * target_ms));
  const auto pairs_for = [this, target_ms](double ms, std::uint64_t pairs) {
    const double wanted = ms > 0 ? target_ms * static_cast<double>(pairs) / ms : static_cast<double>(most_);
    return static_cast<std::size_t>(std::clamp(wanted, 1.0, static_cast<double>(most_)));
  };
  if (report.candidate_pairs != 0) size_.most = pairs_for(report.narrow_ms, report.candidate_pairs);
  if (report.heavy_ms > 0) size_.heavy = pairs_for(report.heavy_ms, report.heavy_pairs);
}

void balance(Balancer& balancer, std::uint64_t step, ExecutionReport& report, Timeline* timeline) {
  report.decision = balancer.after_step(step, report);
  if (timeline == nullptr) return;
  timeline->count("split: broad threads", report.split.broad);
  if (report.decision.action == BalanceAction::none) return;
  timeline->note("step " + std::to_string(step) + ": " + std::string(name(report.decision.action)) + " " +
                 text(report.decision.before) + " -> " + text(report.decision.after) + ", " +
                 std::string(report.decision.reason));
}

}  // namespace tandem
