#include "executors.h"

namespace tandem {
namespace {

/// Broad, then narrow, on the calling thread.
class SequentialExecutor final : public Executor {
 public:
  explicit SequentialExecutor(const ExecutorOptions& options)
      : batch_pairs_(options.batch_pairs), joined_(options.joined) {}

  void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
           Timeline* timeline) override {
    state_.begin(work, contacts, {batch_pairs_}, joined_ ? StepForm::overlapped : StepForm::caller, std::move(stop),
                 timeline);
    run_on_caller(state_);
    report.threads = 1;
    report.split = {1, 0};
    report.decision.reason = "one thread does both phases";
    state_.end(report);
  }

 private:
  std::size_t batch_pairs_;
  bool joined_;
  StepState state_;
};

}  // namespace

std::unique_ptr<Executor> make_sequential_executor(const ExecutorOptions& options) {
  return std::make_unique<SequentialExecutor>(options);
}

}  // namespace tandem
