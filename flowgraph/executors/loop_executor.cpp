// Executors by parallel loops of oneTBB: barrier (one phase after the other) and fused (tile by tile).
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "executors/executors.h"
#include "executors/step_frame.h"

namespace tandem {
namespace {

/// Parallel loops of oneTBB over each stage's blocks. ExecutorKind::barrier ends the broad phase before the narrow one
/// begins; ExecutorKind::fused narrows the pairs of each tile at once, on the thread that found them.
class LoopExecutor final : public Executor {
 public:
  explicit LoopExecutor(const ExecutorOptions& options)
      : fused_(options.kind == ExecutorKind::fused),
        wished_(wished_threads(options)),
        frame_(options, false, !fused_) {}

  void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
           Timeline* timeline) override {
    const int threads = tbb_threads(wished_);
    if (frame_.begin({work, contacts, report, std::move(stop), timeline}, threads, host_cancellation())) {
      report.split = {threads, threads};
      report.decision.reason = "both phases have all threads";
      if (threads == tbb::this_task_arena::max_concurrency()) {
        // Isolated: no other task of the host runs in this thread while it waits
        tbb::this_task_arena::isolate([this] { run_stages(); });
      } else {
        if (!arena_ || arena_->max_concurrency() != threads) arena_ = std::make_unique<tbb::task_arena>(threads);
        arena_->execute([this] { run_stages(); });
      }
    }
    frame_.end(work, report);
  }
  std::size_t memory() const override { return frame_.memory(); }

 private:
  struct Shelf final : Delivery {
    void deliver(Batch&) override {}  // the pool holds all batches; they are narrowed after the barrier
  };
  struct AtOnce final : Delivery {
    explicit AtOnce(StepState& state) : state(state) {}
    void deliver(Batch& batch) override { state.process(batch); }
    StepState& state;
  };

  // Every block is one task, since blocks are made about 10 us long. The context is isolated: a cancellation of the
  // caller's would leave blocks undone.
  template <class Body>
  static void for_each(std::size_t n, const Body& body) {
    tbb::task_group_context context(tbb::task_group_context::isolated);
    // Isolated: a user's callback that waits for tasks of its own must not be given another block of this loop.
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
    // Each filled batch counts as open work, which keeps the stage open until the last one is narrowed.
    for (BatchWriter& writer : writers) writer.flush();
    if (state_.stage() != stage) return;
    ready_.clear();
    for (Batch* batch : state_.batches())
      if (batch->count != 0) ready_.push_back(batch);
    const auto rest = std::stable_partition(ready_.begin(), ready_.end(), [](const Batch* b) { return b->heavy; });
    std::stable_partition(ready_.begin(), rest, [](const Batch* batch) { return batch->costliest; });
    // Tasks take batches by a counter: oneTBB gives threads ranges of indices, and the costliest batches are
    // neighbours.
    std::atomic<std::size_t> next{0};
    for_each(ready_.size(),
             [&](std::size_t) { state_.process(*ready_[next.fetch_add(1, std::memory_order_relaxed)]); });
  }

  bool fused_;
  int wished_;
  std::unique_ptr<tbb::task_arena> arena_;
  StepFrame frame_;
  StepState& state_ = frame_.state();
  std::vector<Batch*> ready_;  // kept from step to step
};

}  // namespace

std::unique_ptr<Executor> make_loop_executor(const ExecutorOptions& options) {
  return std::make_unique<LoopExecutor>(options);
}

}  // namespace tandem
