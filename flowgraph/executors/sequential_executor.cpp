// The sequential executor: a step on the calling thread.
#include "executors/executors.h"
#include "executors/step_frame.h"

namespace tandem {
namespace {

/// The broad phase, then the narrow phase, on the calling thread. On request the step takes the stages of a shared step
/// (StepForm::overlapped or ordered), to measure what these stages cost.
class SequentialExecutor final : public Executor {
 public:
  explicit SequentialExecutor(const ExecutorOptions& options)
      : batch_pairs_(options.batches.pairs),
        form_(options.sharing.form == StepForm::automatic ? StepForm::caller : options.sharing.form) {}

  void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
           Timeline* timeline) override {
    state_.begin(work, contacts, {batch_pairs_, 1}, form_, std::move(stop), timeline);
    caller_.run(state_);
    report.threads = 1;
    report.split = {1, 0};
    report.decision.reason = "one thread does both phases";
    state_.end(report);
  }
  std::size_t memory() const override { return state_.memory(); }

 private:
  std::size_t batch_pairs_;
  StepForm form_;
  CallerAlone caller_;
  StepState state_;
};

}  // namespace

std::unique_ptr<Executor> make_sequential_executor(const ExecutorOptions& options) {
  return std::make_unique<SequentialExecutor>(options);
}

}  // namespace tandem
