// The interface of executors.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <stop_token>

#include "tandem/flowgraph/contact_list.h"
#include "tandem/flowgraph/options.h"
#include "tandem/flowgraph/report.h"
#include "tandem/flowgraph/step_work.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem {

/// Upper limit of stay_awake, in microseconds: a longer pause is none within a loop of steps.
inline constexpr double longest_awake = 1e5;

struct ExecutorOptions {
  ExecutorKind kind = ExecutorKind::flowgraph;
  int threads = 0;  ///< threads in all, the caller counted, [0, 1024]; 0 asks the runtime
  BalanceOptions balance{};
  PairBatchOptions batches{};
  SharingOptions sharing{};
  /// Microseconds, [0, longest_awake]; 0: never. For executor flowgraph: after a step, if the next one is to be shared,
  /// its workers spin in its arenas for at most so long, so that a step that comes sooner finds them awake. Other work
  /// of the process on oneTBB has to do without them meanwhile.
  double stay_awake = 0;
};

/// Runs steps. The contacts do not depend on the executor, on threads or on timing. An executor of your own derives
/// from this class (examples/own_executor.cpp) and uses NarrowingSink and Joiner.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Runs one step to the end. The first exception that `work` throws ends the step and is thrown here; the executor is
  /// ready for the next step then. A stop request ends the step early, with empty contacts.
  virtual void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
                   Timeline* timeline) = 0;
  /// Bytes held between steps: batches, scratch for sorting, buffers of answers.
  virtual std::size_t memory() const { return 0; }
};

/// Makes an executor of your own from these options, of which it takes those that it can use.
using ExecutorFactory = std::function<std::unique_ptr<Executor>(const ExecutorOptions&)>;

/// Makes a built-in executor. Throws std::invalid_argument naming the option, its value and what is allowed.
std::unique_ptr<Executor> make_executor(const ExecutorOptions& options);

}  // namespace tandem
