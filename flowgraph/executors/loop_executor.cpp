#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "executors/executors.h"

namespace tandem {
namespace {

/// Parallel loops of oneTBB over each stage's blocks. ExecutorKind::barrier ends the broad phase before the narrow one
/// begins; ExecutorKind::fused narrows the pairs of each tile at once, on the thread that found them.
class LoopExecutor final : public Executor {
 public:
  explicit LoopExecutor(const ExecutorOptions& options)
      : fused_(options.kind == ExecutorKind::fused),
        wished_(options.balance.split.dynamic() ? options.threads
                                                : options.balance.split.broad + options.balance.split.narrow),
        batch_size_(options.batches.pairs),
        form_(options.sharing.form, options.sharing.short_step_ms, !fused_) {}

  void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
           Timeline* timeline) override {
    const int threads = tbb_threads(wished_);
    const StepForm form = threads == 1 ? StepForm::caller : form_.next();
    state_.begin(work, contacts, batch_size_.get(form), form, std::move(stop), timeline, host_cancellation());
    if (form == StepForm::caller) {
      run_on_caller(state_);
      if (threads > 1) report.issues |= bit(StepIssue::ran_on_caller);
    } else if (threads == tbb::this_task_arena::max_concurrency()) {
      tbb::this_task_arena::isolate([this] { run_stages(); });  // while it waits, no other task of the host
    } else {
      if (!arena_ || arena_->max_concurrency() != threads) arena_ = std::make_unique<tbb::task_arena>(threads);
      arena_->execute([this] { run_stages(); });
    }
    report.threads = threads;
    report.split = threads == 1 ? Split{1, 0} : Split{threads, threads};
    report.decision.reason = threads == 1 ? "one thread does both phases" : "both phases have all threads";
    state_.end(report);
    batch_size_.learn(report);
    if (threads > 1) form_.learn(report, state_.work_ms(), load_of(work, report));
  }

 private:
  struct Shelf final : Delivery {
    void deliver(Batch&) override {}  // the pool knows all batches; they are processed after the barrier
  };
  struct AtOnce final : Delivery {
    explicit AtOnce(StepState& state) : state(state) {}
    void deliver(Batch& batch) override { state.process(batch); }
    StepState& state;
  };

  // Every block is one task: they are made about 10 us long. The context is not bound to the caller's, whose
  // cancellation would leave blocks undone.
  template <class Body>
  static void for_each(std::size_t n, const Body& body) {
    tbb::task_group_context context(tbb::task_group_context::isolated);
    // Nor may a user's callback that waits for tasks of its own be given another block of this loop.
    const auto alone = [&](std::size_t i) { tbb::this_task_arena::isolate([&] { body(i); }); };
    tbb::parallel_for(std::size_t{0}, n, alone, tbb::simple_partitioner(), context);
  }

  void run_stages() {
    while (!state_.finished()) {
      const std::size_t stage = state_.stage();
      if (stage == state_.shared_stage()) {
        fused_ ? run_fused() : run_both_phases();
        continue;
      }
      for_each(state_.blocks(stage), [&](std::size_t) {
        if (std::size_t block; state_.take(stage, block)) state_.run(stage, block);
      });
    }
  }

  void run_fused() {
    AtOnce at_once(state_);
    for_each(state_.blocks(state_.shared_stage()), [&](std::size_t) {
      std::size_t tile;
      if (!state_.take(state_.shared_stage(), tile)) return;
      BatchWriter writer(state_, at_once);
      state_.run_tile(tile, writer);
      writer.flush();
    });
  }

  void run_both_phases() {
    Shelf shelf;
    tbb::enumerable_thread_specific<BatchWriter> writers([&] { return BatchWriter(state_, shelf); });
    const std::size_t stage = state_.shared_stage();
    for_each(state_.blocks(stage), [&](std::size_t) {
      if (std::size_t tile; state_.take(stage, tile)) state_.run_tile(tile, writers.local());
    });
    // Counting each filled batch as open keeps the stage open until the last one is processed.
    for (BatchWriter& writer : writers) writer.flush();
    if (state_.stage() != stage) return;
    std::vector<Batch*>& ready = state_.shelf();
    ready.clear();
    for (Batch* batch : state_.batches())
      if (batch->count != 0) ready.push_back(batch);
    const auto rest = std::stable_partition(ready.begin(), ready.end(), [](const Batch* b) { return b->heavy; });
    std::stable_partition(ready.begin(), rest, [](const Batch* batch) { return batch->costliest; });
    std::atomic<std::size_t> next{0};  // threads are given ranges: by these the costliest would be one thread's
    for_each(ready.size(), [&](std::size_t) { state_.process(*ready[next.fetch_add(1, std::memory_order_relaxed)]); });
  }

  bool fused_;
  int wished_;
  BatchSize batch_size_;
  FormChooser form_;
  std::unique_ptr<tbb::task_arena> arena_;
  StepState state_;
};

}  // namespace

std::unique_ptr<Executor> make_loop_executor(const ExecutorOptions& options) {
  return std::make_unique<LoopExecutor>(options);
}

}  // namespace tandem
