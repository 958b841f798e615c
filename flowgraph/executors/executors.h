// The executors' factories.
#pragma once
#include <functional>
#include <memory>
#include <string>

#include "tandem/flowgraph/executor.h"

namespace tandem {

std::unique_ptr<Executor> make_sequential_executor(const ExecutorOptions& options);
std::unique_ptr<Executor> make_loop_executor(const ExecutorOptions& options);
std::unique_ptr<Executor> make_threads_executor(const ExecutorOptions& options);
std::unique_ptr<Executor> make_flowgraph_executor(const ExecutorOptions& options);

/// The number of threads asked for: the sum of a fixed split, else `threads`.
inline int wished_threads(const ExecutorOptions& options) {
  const Split fixed = options.balance.split;
  return fixed.dynamic() ? options.threads : fixed.broad + fixed.narrow;
}

/// Threads that oneTBB may give to the caller: the number asked for (0: that of the arena the caller is in), capped by
/// the process's limit.
int tbb_threads(int wished);

/// A function that tells whether the task group of the calling task has been cancelled; valid while that task runs.
std::function<bool()> host_cancellation();

/// The split as options and reports write it: "1-3".
inline std::string text(Split split) { return std::to_string(split.broad) + "-" + std::to_string(split.narrow); }

}  // namespace tandem
