// The common prologue and epilogue of a step.
#pragma once
#include <cstdint>
#include <functional>
#include <stop_token>
#include <vector>

#include "measurement/balancer.h"
#include "step/batch_size.h"
#include "step/step_form.h"
#include "step/step_state.h"
#include "tandem/flowgraph/executor.h"

namespace tandem {

/// The arguments of Executor::run().
struct StepCall {
  StepWork& work;
  ContactList& contacts;
  ExecutionReport& report;
  std::stop_token stop;
  Timeline* timeline;
};

/// Runs whole steps on the calling thread: the broad phase, then the narrow phase, the answers in order at once; or, if
/// the step was begun in a shared form, with that form's stages, which join the answers.
class CallerAlone {
 public:
  void run(StepState& state);

 private:
  std::vector<Batch*> waiting_;  // kept from step to step
};

/// The common prologue and epilogue of multi-threaded executors: chooses the form of the step and the size of its
/// batches from measurements of earlier steps, and runs a step with too little work on the caller alone.
class StepFrame {
 public:
  /// `strict`: the two phases at once, no thread changes phase. `can_order`: StepForm::ordered may be chosen.
  StepFrame(const ExecutorOptions& options, bool strict, bool can_order);

  /// Begins a step. True if threads are to share it: the executor then runs it and reports its split; else the caller
  /// has run it.
  bool begin(StepCall call, int threads, std::function<bool()> host_cancelled);
  /// Ends the step and learns from its measurements; throws what the step threw.
  void end(const StepWork& work, ExecutionReport& report);
  /// After a shared step: moves threads between the phases, and writes the decision into the report and the timeline.
  void balance(Balancer& balancer, ExecutionReport& report, Timeline* timeline) const;
  StepState& state() { return state_; }
  std::size_t memory() const { return state_.memory(); }
  /// True if the next step has enough work to be shared, provided that threads are available.
  bool shares_next() const { return form_.next() != StepForm::caller; }

 private:
  BatchSize batch_size_;
  FormChooser form_;
  CallerAlone caller_;
  StepState state_;
  std::uint64_t steps_ = 0;
};

}  // namespace tandem
