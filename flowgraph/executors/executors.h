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

/// Threads that oneTBB may give to the caller: the wish (0: the arena it is in), capped by the process's limit.
int tbb_threads(int wished);

/// Asks whether the task group that the calling task belongs to has been cancelled; valid while that task runs.
std::function<bool()> host_cancellation();

/// As options and reports tell it: 1-3.
inline std::string text(Split split) { return std::to_string(split.broad) + "-" + std::to_string(split.narrow); }

}  // namespace tandem
