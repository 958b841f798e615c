// Makes the executor that the options ask for, after checking them.
#include "tandem/flowgraph/executor.h"

#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/task.h>
#include <oneapi/tbb/task_arena.h>
#include <oneapi/tbb/task_group.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "executors/executors.h"

namespace tandem {
namespace {

constexpr int most_threads = 1024;
constexpr std::size_t most_pairs = 65536, longest_queue = std::size_t{1} << 20;
constexpr double longest_short_step = 1e6;  // ms

std::string whole(double x) { return std::to_string(static_cast<long>(x)); }

std::string decimal(double x) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, x).ptr};
}

void require(bool good, const std::string& message) {
  if (!good) throw std::invalid_argument(message);
}

}  // namespace

std::unique_ptr<Executor> make_executor(const ExecutorOptions& options) {
  require(options.threads >= 0 && options.threads <= most_threads, "threads: " + std::to_string(options.threads) +
                                                                       ", allowed: 0 (ask the runtime) to " +
                                                                       std::to_string(most_threads));
  if (const Split split = options.balance.split; !split.dynamic()) {
    require(split.broad >= 1 && split.narrow >= 1,
            "balance.split: " + text(split) + ", allowed: at least one thread for each phase");
    const std::int64_t sum = std::int64_t{split.broad} + split.narrow;
    require(options.threads == 0 || sum == options.threads, "balance.split: " + text(split) +
                                                                ", allowed: two numbers that add up to the threads, " +
                                                                std::to_string(options.threads));
    require(sum <= most_threads,
            "balance.split: " + text(split) + ", allowed: at most " + std::to_string(most_threads) + " threads in all");
  }
  require(options.batches.pairs >= 1 && options.batches.pairs <= most_pairs,
          "batches.pairs: " + std::to_string(options.batches.pairs) + ", allowed: 1 to " + std::to_string(most_pairs));
  require(options.batches.queue_capacity <= longest_queue,
          "batches.queue_capacity: " + std::to_string(options.batches.queue_capacity) + ", allowed: 0 (chosen) to " +
              std::to_string(longest_queue));
  require(options.sharing.short_step_ms >= 0 && options.sharing.short_step_ms <= longest_short_step,
          "sharing.short_step_ms: " + decimal(options.sharing.short_step_ms) + ", allowed: 0 (never) to " +
              whole(longest_short_step));
  require(options.stay_awake >= 0 && options.stay_awake <= longest_awake, "stay_awake: " + decimal(options.stay_awake) +
                                                                              ", allowed: 0 (never) to " +
                                                                              whole(longest_awake) + " microseconds");
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
  // oneTBB counts processors from the affinity mask on first use; asking here keeps a caller that is pinned later from
  // hiding them.
  tbb::info::default_concurrency();
  const auto limit = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const int most = static_cast<int>(std::min<std::size_t>(limit, most_threads));
  return std::max(1, std::min(wished == 0 ? tbb::this_task_arena::max_concurrency() : wished, most));
}

std::function<bool()> host_cancellation() {
  tbb::task_group_context* context = tbb::task::current_context();
  if (context == nullptr) return {};
  return [context] { return context->is_group_execution_cancelled(); };
}

}  // namespace tandem
