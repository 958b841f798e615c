#include <oneapi/tbb/concurrent_queue.h>
#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <mutex>
#include <numeric>
#include <optional>
#include <thread>

#include "executors/executors.h"

namespace tandem {
namespace {

using tbb::flow::continue_msg;
using tbb::flow::function_node;
using tbb::flow::graph;
using tbb::flow::unlimited;

/// Asks a node's body to take part in the step.
struct Runner {};

/// A graph with one node, in an arena of its own. The number of threads at work in it is the arena's limit.
class Phase {
 public:
  template <class Body>
  Phase(int concurrency, Body body) : arena_(concurrency, 1), context_(tbb::task_group_context::isolated) {
    // A graph stays with the arena in which it was made or last reset, whoever sends it messages.
    arena_.execute([&] {
      graph_.emplace(context_);
      node_.emplace(*graph_, unlimited, [body](Runner) noexcept {
        // A user's callback may wait for tasks of its own; it must not be given another runner meanwhile, which would
        // wait for the tile that this one holds.
        tbb::this_task_arena::isolate(body);
        return continue_msg();
      });
    });
  }

  void resize(int concurrency) {
    if (concurrency == arena_.max_concurrency()) return;
    arena_.terminate();
    arena_.initialize(concurrency, 1);
    arena_.execute([this] { graph_->reset(); });
  }

  void put_runner() { node_->try_put({}); }

  /// The caller joins the arena with `runners` more messages until its work is done.
  void wait(int runners) {
    arena_.execute([&] {
      for (int i = 0; i < runners; ++i) put_runner();
      graph_->wait_for_all();
    });
  }

 private:
  tbb::task_arena arena_;
  // Not bound to the caller's: that one may end before this graph does, and a step that lost messages would hang.
  tbb::task_group_context context_;
  std::optional<graph> graph_;  // before the node, so that it outlives it
  std::optional<function_node<Runner, continue_msg>> node_;
};

/// The product: the broad phase's node in one arena, the narrow phase's in another, a bounded queue of batches
/// between them. Split X-Y sends X runners into the broad node and Y into the narrow one; the arenas are resized when
/// the balancer moves a thread.
///
/// Work is conserved unless the split is strict: a producer that finds the queue full narrows a batch itself,
/// producers without tiles drain the queue, and starved narrow runners take tiles. So threads help the other phase
/// inside a step at once, where a worker needs 100 us to change arenas; the split says where they begin.
class FlowGraphExecutor final : public Executor, private Delivery {
 public:
  explicit FlowGraphExecutor(const ExecutorOptions& options)
      : options_(options),
        batch_size_(options.batches.pairs),
        form_(options.balance.strict ? StepForm::overlapped : options.sharing.form, options.sharing.short_step_ms,
              true) {}

  void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
           Timeline* timeline) override {
    const Split fixed = options_.balance.split;
    const int threads = tbb_threads(fixed.dynamic() ? options_.threads : fixed.broad + fixed.narrow);
    const StepForm form = threads == 1 ? StepForm::caller : form_.next();
    const bool shared = form != StepForm::caller;
    report.threads = threads;
    state_.begin(work, contacts, batch_size_.get(form), form, std::move(stop), timeline, host_cancellation());
    if (shared) {
      prepare(threads);
      report.split = split_;
      run_shared();
    } else {
      report.split = {1, 0};
      report.decision.reason = threads == 1 ? "one thread does both phases" : "the step stayed on the caller";
      if (threads > 1) report.issues |= bit(StepIssue::ran_on_caller);
      run_on_caller(state_);
    }
    const std::uint64_t step = step_++;
    state_.end(report);
    batch_size_.learn(report);
    if (threads > 1) form_.learn(report, state_.work_ms(), load_of(work, report));
    if (shared) balance(*balancer_, step, report, timeline);
  }

 private:
  using Queue = tbb::concurrent_bounded_queue<Batch*>;

  /// Arenas and graphs for the threads and the split of this step.
  void prepare(int threads) {
    if (!balancer_ || threads != threads_) {
      threads_ = threads;
      // The process's limit may leave fewer threads than a fixed split asks for; its proportion is kept then.
      Split fixed = options_.balance.split;
      if (!fixed.dynamic() && fixed.broad + fixed.narrow != threads) {
        fixed.broad = std::clamp(fixed.broad * threads / (fixed.broad + fixed.narrow), 1, threads - 1);
        fixed.narrow = threads - fixed.broad;
      }
      balancer_.emplace(threads, fixed, options_.balance.rule);
      const std::size_t chosen = usual_queue_capacity(threads);
      // A strict producer must neither help nor wait, so its queue never gets full: the paper's array.
      for (Queue& queue : queues_)
        queue.set_capacity(options_.balance.strict
                               ? std::ptrdiff_t{1} << 30
                               : static_cast<std::ptrdiff_t>(
                                     options_.batches.queue_capacity != 0 ? options_.batches.queue_capacity : chosen));
    }
    split_ = balancer_->split();
    // The caller works in the broad arena and then joins the narrow one: together they ask for threads - 1 workers.
    if (!broad_) {
      broad_.emplace(split_.broad, [this] { run_broad(); });
      narrow_.emplace(split_.narrow + 1, [this] { run_narrow(); });
    }
    broad_->resize(split_.broad);
    narrow_->resize(split_.narrow + 1);
  }

  void run_shared() {
    present_.store(0, std::memory_order_relaxed);
    for (int i = 0; i < split_.narrow; ++i) narrow_->put_runner();
    broad_->wait(split_.broad);
    narrow_->wait(0);
  }

  void run_broad() {
    take_part(
        state_, [](std::size_t) { return true; },
        [this] {
          BatchWriter writer(state_, *this);
          if (options_.balance.strict) {
            for (std::size_t tile; state_.take(state_.shared_stage(), tile);) state_.run_tile(tile, writer);
            writer.flush();
            watch_narrow();
          } else {
            overlap(writer, true);
          }
          return true;
        });
  }

  void run_narrow() {
    take_part(
        state_, [this](std::size_t stage) { return !options_.balance.strict || !state_.is_broad(stage); },
        [this] {
          if (options_.balance.strict) return take_batches();
          BatchWriter writer(state_, *this);
          overlap(writer, false);
          return true;
        });
  }

  /// A strict narrow runner: leaves when it has been starved for a while; the next batch's message brings it back.
  bool take_batches() {
    constexpr int patience = 200;  // yields, some 50 us
    Batch* batch = nullptr;
    present_.fetch_add(1);
    for (int starved = 0; state_.stage() == state_.shared_stage();) {
      if (pop(batch)) {
        state_.process(*batch);
        starved = 0;
      } else if (state_.help()) {
        starved = 0;
      } else if (++starved < patience) {
        std::this_thread::yield();
      } else {
        present_.fetch_sub(1);
        std::atomic_thread_fence(std::memory_order_seq_cst);
        // A batch that came in between found this runner still present and sent no message.
        if (nothing_queued()) return false;
        present_.fetch_add(1);
        starved = 0;
      }
    }
    present_.fetch_sub(1);
    return true;
  }

  /// A strict broad runner without tiles does nothing more. But where the scheduler grants the narrow arena no worker,
  /// as under a limit of one thread, the step must still end: then it takes the batches after all.
  void watch_narrow() {
    constexpr auto patience = std::chrono::microseconds(500);
    for (auto look = Clock::now() + patience; state_.stage() == state_.shared_stage(); std::this_thread::yield()) {
      if (Clock::now() < look) continue;
      look = Clock::now() + patience;
      if (Batch* batch = nullptr; present_.load() == 0 && pop(batch)) state_.process(*batch);
    }
  }

  /// One thread's part in the shared phase with work conserved. Both sides do both things; they differ in what they
  /// look for first. It ends when there is neither a tile nor a batch left that nobody works on, and nobody has pairs
  /// in hand: what comes with the last tile may be most of the work.
  void overlap(BatchWriter& writer, bool tiles_first) {
    const std::size_t stage = state_.shared_stage();
    Batch* batch = nullptr;
    std::size_t tile = 0;
    writers_.fetch_add(1);
    // With the last tile taken nobody keeps pairs in hand while there are batches.
    while (!state_.all_taken(stage)) {
      if (state_.help())
        continue;
      else if (!tiles_first && pop(batch))
        state_.process(*batch);
      else if (state_.take(stage, tile))
        state_.run_tile(tile, writer);
    }
    writer.flush();
    writers_.fetch_sub(1);
    while (state_.stage() == stage) {
      if (state_.help())
        continue;
      else if (pop(batch))
        state_.process(*batch);
      else if (state_.tiles_left() || writers_.load() != 0 || !nothing_queued())
        std::this_thread::yield();
      else
        return;
    }
  }

  bool push(Queue& queue, Batch& batch) {
#if TBB_INTERFACE_VERSION < 12090 && !defined(__x86_64__)
    // Before 2021.9 a push reads what the push before it wrote without an order between the two: where the processor has
    // none of its own, batches are lost.
    const std::scoped_lock one_at_a_time(pushing_);
#endif
    return queue.try_push(&batch);
  }
  bool pop(Batch*& batch) {
    return std::any_of(queues_.begin(), queues_.end(), [&](Queue& queue) { return queue.try_pop(batch); });
  }
  bool nothing_queued() const {
    return std::all_of(queues_.begin(), queues_.end(), [](const Queue& queue) { return queue.empty(); });
  }

  /// From a writer: into the queue, or, when it is full, another batch out of it.
  void deliver(Batch& batch) override {
    Batch* other = nullptr;
    Queue& queue = queues_[batch.costliest ? 0 : batch.heavy ? 1 : 2];
    while (!push(queue, batch))
      if (pop(other)) state_.process(*other);
    state_.count_queue(std::accumulate(queues_.begin(), queues_.end(), std::size_t{0},
                                       [](std::size_t sum, const Queue& one) { return sum + waiting(one); }));
    if (!options_.balance.strict) return;  // runners that take both tiles and batches stay to the end
    std::atomic_thread_fence(std::memory_order_seq_cst);
    try {
      if (present_.load() < split_.narrow) narrow_->put_runner();
    } catch (...) {
      state_.capture();  // the batch is in the queue all the same
    }
  }

  /// A size is the difference of two counters that are read one after the other: other threads may come in between.
  static std::size_t waiting(const Queue& queue) {
    return static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(queue.size(), 0, queue.capacity()));
  }

  ExecutorOptions options_;
  BatchSize batch_size_;
  FormChooser form_;
  int threads_ = 0;
  Split split_;
  std::uint64_t step_ = 0;
  std::optional<Balancer> balancer_;
  StepState state_;
  std::array<Queue, 3> queues_;          // by turns: the costliest batches, other heavy ones, the rest
#if TBB_INTERFACE_VERSION < 12090 && !defined(__x86_64__)
  std::mutex pushing_;
#endif
  std::atomic<int> present_{0};          // strict narrow runners
  std::atomic<int> writers_{0};          // of those that conserve work, who may still have pairs in hand
  std::optional<Phase> broad_, narrow_;  // last: their bodies use what is above
};

}  // namespace

std::unique_ptr<Executor> make_flowgraph_executor(const ExecutorOptions& options) {
  return std::make_unique<FlowGraphExecutor>(options);
}

}  // namespace tandem
