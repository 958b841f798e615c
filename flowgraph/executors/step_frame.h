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

/// What Executor::run() is given.
struct StepCall {
  StepWork& work;
  ContactList& contacts;
  ExecutionReport& report;
  std::stop_token stop;
  Timeline* timeline;
};

/// Whole steps on the calling thread: broad, then narrow; in order, unless the step was begun as one of several
/// threads, whose answers are joined.
class CallerAlone {
 public:
  void run(StepState& state);

 private:
  std::vector<Batch*> waiting_;  // kept from step to step
};

/// What executors with several threads do around each step: its form and the size of its batches are chosen by the
/// steps before it, and a step whose form says so stays on the caller.
class StepFrame {
 public:
  /// `strict`: both phases at once, threads apart. `can_order`: whether StepForm::ordered may be chosen.
  StepFrame(const ExecutorOptions& options, bool strict, bool can_order);

  /// Begins a step. True if threads are to share it, whose executor then tells its split and reason; else the caller
  /// has run it.
  bool begin(StepCall call, int threads, std::function<bool()> host_cancelled);
  /// Ends it and learns from what was measured; throws what the step threw.
  void end(const StepWork& work, ExecutionReport& report);
  /// After a step that was shared: moves threads, and writes what was decided into the report and the timeline.
  void balance(Balancer& balancer, ExecutionReport& report, Timeline* timeline) const;
  StepState& state() { return state_; }
  std::size_t memory() const { return state_.memory(); }
  /// Whether the next step is one to share, as far as the threads are there.
  bool shares_next() const { return form_.next() != StepForm::caller; }

 private:
  BatchSize batch_size_;
  FormChooser form_;
  CallerAlone caller_;
  StepState state_;
  std::uint64_t steps_ = 0;
};

}  // namespace tandem
