// The common prologue and epilogue of multi-threaded executors: form of the step, batch size, balance of threads.
#include "executors/step_frame.h"

#include <string>
#include <utility>

#include "executors/executors.h"

namespace tandem {

void CallerAlone::run(StepState& state) {
  struct Shelf final : Delivery {
    explicit Shelf(std::vector<Batch*>& batches) : batches(batches) {}
    void deliver(Batch& batch) override { batches.push_back(&batch); }
    std::vector<Batch*>& batches;
  } shelf(waiting_);
  waiting_.clear();
  take_part(
      state, [](std::size_t) { return true; },
      [&] {
        BatchWriter writer(state, shelf);
        for (std::size_t tile; state.take(state.shared_stage(), tile);) state.run_tile(tile, writer);
        writer.flush();
        if (state.form() == StepForm::caller)
          state.process_in_order(waiting_);
        else
          for (Batch* batch : waiting_) state.process(*batch);
      });
}

StepFrame::StepFrame(const ExecutorOptions& options, bool strict, bool can_order)
    : batch_size_(options.batches.pairs),
      form_(strict ? StepForm::overlapped : options.sharing.form, options.sharing.short_step_ms, can_order) {}

bool StepFrame::begin(StepCall call, int threads, std::function<bool()> host_cancelled) {
  const StepForm form = threads == 1 ? StepForm::caller : form_.next();
  call.report.threads = threads;
  state_.begin(call.work, call.contacts, batch_size_.get(form), form, std::move(call.stop), call.timeline,
               std::move(host_cancelled));
  if (form != StepForm::caller) return true;
  call.report.split = {1, 0};
  call.report.decision.reason = threads == 1 ? "one thread does both phases" : "the step stayed on the caller";
  if (threads > 1) call.report.issues |= bit(StepIssue::ran_on_caller);
  caller_.run(state_);
  return false;
}

void StepFrame::end(const StepWork& work, ExecutionReport& report) {
  ++steps_;
  state_.end(report);
  batch_size_.learn(report);
  // The load that a step's time is proportional to.
  const auto load = static_cast<double>(work.bodies() + report.candidate_pairs);
  if (report.threads > 1) form_.learn(report, state_.work_ms(), load);
}

void StepFrame::balance(Balancer& balancer, ExecutionReport& report, Timeline* timeline) const {
  const std::uint64_t step = steps_ - 1;
  report.decision = balancer.after_step(step, report);
  if (timeline == nullptr) return;
  timeline->count("split: broad threads", report.split.broad);
  if (report.decision.action == BalanceAction::none) return;
  timeline->note("step " + std::to_string(step) + ": " + std::string(name(report.decision.action)) + " " +
                 text(report.decision.before) + " -> " + text(report.decision.after) + ", " +
                 std::string(report.decision.reason));
}

}  // namespace tandem
