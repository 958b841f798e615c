// The executor `threads`.
#include <atomic>
#include <thread>
#include <vector>

#include "answers/pair_array.h"
#include "executors/executors.h"
#include "executors/step_frame.h"

namespace tandem {
namespace {

/// The paper's own design on std::thread alone, as the baseline: a control thread for each phase (the caller for the
/// broad one) with workers of its own, the shared array of pairs between them, and a split that is balanced from
/// measured times. Threads without work of their own phase go on with the other, unless the split is strict, as the
/// paper's; without any they sleep, as between steps.
class ThreadsExecutor final : public Executor {
 public:
  explicit ThreadsExecutor(const ExecutorOptions& options)
      : threads_(count(options)),
        strict_(options.balance.strict),
        frame_(options, strict_, true),
        balancer_(std::max(2, threads_), options.balance.split, options.balance.rule, options.balance.own_rule) {}

  ~ThreadsExecutor() override {
    leaving_.store(true, std::memory_order_relaxed);
    start_.fetch_add(1, std::memory_order_release);
    start_.notify_all();
  }

  void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
           Timeline* timeline) override {
    const bool shared = frame_.begin({work, contacts, report, std::move(stop), timeline}, threads_, {});
    if (shared) {
      report.split = split_ = balancer_.split();
      run_shared();
    }
    frame_.end(work, report);
    if (shared) frame_.balance(balancer_, report, timeline);
  }
  std::size_t memory() const override { return frame_.memory(); }

 private:
  static int count(const ExecutorOptions& options) {
    const int wished = wished_threads(options);
    return wished != 0 ? wished : static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 1024u));
  }

  struct ArrayDelivery final : Delivery {
    explicit ArrayDelivery(PairArray& array) : array(array) {}
    void deliver(Batch& batch) override { array.put(batch); }
    PairArray& array;
  };

  void run_shared() {
    array_.begin();
    while (static_cast<int>(workers_.size()) < threads_ - 1) {
      const int index = static_cast<int>(workers_.size()) + 1;
      workers_.emplace_back([this, index, seen = start_.load()] { serve(index, seen); });
    }
    running_.store(threads_ - 1, std::memory_order_relaxed);
    start_.fetch_add(1, std::memory_order_release);
    start_.notify_all();
    take_part_as(0);
    for (int left = running_.load(std::memory_order_acquire); left != 0;
         left = running_.load(std::memory_order_acquire))
      running_.wait(left, std::memory_order_acquire);
  }

  void serve(int index, std::uint32_t seen) {
    for (;;) {
      start_.wait(seen, std::memory_order_acquire);
      seen = start_.load(std::memory_order_acquire);
      if (leaving_.load(std::memory_order_relaxed)) return;
      take_part_as(index);
      if (running_.fetch_sub(1, std::memory_order_acq_rel) == 1) running_.notify_one();
    }
  }

  // Threads [0, X) belong to the broad phase, the others to the narrow phase. All of them compute boxes and join
  // results, stages which belong to neither.
  void take_part_as(int index) {
    const bool broad = index < split_.broad;
    take_part(
        state_, [&](std::size_t stage) { return broad || !strict_ || !state_.is_broad(stage); },
        [&] {
          if (broad || !strict_) emit(broad);
          if (!broad || !strict_)
            while (Batch* batch = array_.take()) state_.process(*batch);
        });
  }

  // Takes tiles until none is left. The last writer to leave closes the array then; a thread that the system has
  // suspended is not waited for.
  void emit(bool tiles_first) {
    writers_.fetch_add(1);
    ArrayDelivery delivery(array_);
    BatchWriter writer(state_, delivery);
    for (;;) {
      std::size_t tile = 0;
      if (Batch* batch = tiles_first ? nullptr : array_.try_take())
        state_.process(*batch);
      else if (state_.take(state_.shared_stage(), tile))
        state_.run_tile(tile, writer);
      else
        break;
    }
    writer.flush();
    if (writers_.fetch_sub(1) == 1 && !state_.tiles_left()) array_.close();
  }

  int threads_;
  bool strict_;
  StepFrame frame_;
  StepState& state_ = frame_.state();
  Balancer balancer_;
  PairArray array_;
  Split split_;
  alignas(64) std::atomic<std::uint32_t> start_{0};
  alignas(64) std::atomic<int> running_{0};
  alignas(64) std::atomic<int> writers_{0};
  std::atomic<bool> leaving_{false};
  std::vector<std::jthread> workers_;  // last: threads join before the members that they use are destroyed
};

}  // namespace

std::unique_ptr<Executor> make_threads_executor(const ExecutorOptions& options) {
  return std::make_unique<ThreadsExecutor>(options);
}

}  // namespace tandem
