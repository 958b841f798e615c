#pragma once
#include <memory>
#include <stop_token>

#include "tandem/flowgraph/contact_list.h"
#include "tandem/flowgraph/options.h"
#include "tandem/flowgraph/report.h"
#include "tandem/flowgraph/step_work.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem {

struct ExecutorOptions {
  ExecutorKind kind = ExecutorKind::flowgraph;
  int threads = 0;  ///< in all, the caller counted, [0, 1024]; 0 asks the runtime
  BalanceOptions balance{};
  PairBatchOptions batches{};
  SharingOptions sharing{};
};

/// Runs steps. The contacts do not depend on which executor it is, on threads or on timing.
class Executor {
 public:
  virtual ~Executor() = default;
  /// Runs one step to the end. What `work` throws ends the step and is thrown here (the first one); the executor is
  /// ready for the next step then. A requested stop ends the step early, with empty contacts.
  virtual void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
                   Timeline* timeline) = 0;
};

/// Throws std::invalid_argument naming the option, its value and what is allowed.
std::unique_ptr<Executor> make_executor(const ExecutorOptions& options);

}  // namespace tandem
