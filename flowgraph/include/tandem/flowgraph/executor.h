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

/// Microseconds that workers may stay awake between two steps: more is no pause within a loop of steps.
inline constexpr double longest_awake = 1e5;

struct ExecutorOptions {
  ExecutorKind kind = ExecutorKind::flowgraph;
  int threads = 0;  ///< in all, the caller counted, [0, 1024]; 0 asks the runtime
  BalanceOptions balance{};
  PairBatchOptions batches{};
  SharingOptions sharing{};
  /// Microseconds, [0, longest_awake]; 0: never. For executor flowgraph: after a step, if the next one is to be shared,
  /// the workers that help with it spin in its arenas for at most so long, so that a step that comes sooner finds them
  /// awake. What else the process runs with oneTBB has to do without them meanwhile.
  double stay_awake = 0;
};

/// Runs steps. The contacts do not depend on which executor it is, on threads or on timing. One of one's own derives
/// from this (examples/own_executor.cpp): NarrowingSink and Joiner are its parts.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Runs one step to the end. What `work` throws ends the step and is thrown here (the first one); the executor is
  /// ready for the next step then. A requested stop ends the step early, with empty contacts.
  virtual void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
                   Timeline* timeline) = 0;
  /// Bytes held between steps: batches, what puts them in order, answers on their way to the list.
  virtual std::size_t memory() const { return 0; }
};

/// Makes an executor of one's own, of these options what it can use.
using ExecutorFactory = std::function<std::unique_ptr<Executor>(const ExecutorOptions&)>;

/// Throws std::invalid_argument naming the option, its value and what is allowed.
std::unique_ptr<Executor> make_executor(const ExecutorOptions& options);

}  // namespace tandem
