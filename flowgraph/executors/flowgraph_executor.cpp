// The executor `flowgraph`: a step as two oneTBB flow graphs, one for the threads of each phase, with a bounded queue
// of batches between them; after the pipeline of Avril, Gouranton and Arnaldi (ICAT 2010).
#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include "executors/awake_workers.h"
#include "executors/batch_queue.h"
#include "executors/executors.h"
#include "executors/step_frame.h"

namespace tandem {
namespace {

using tbb::flow::continue_msg;
using tbb::flow::function_node;
using tbb::flow::make_edge;
using tbb::flow::unlimited;

/// The phase whose work a thread looks for first.
enum class Phase { broad, narrow };

/// The default executor. Each phase has an arena, of X and Y threads for the split X-Y, and in it a graph of the step's
/// stages. Each thread carries a message along the edges: at a node it takes blocks of the stage until none is left,
/// and goes on when the stage is over:
///
///   broad arena:    update -> prepare -> tiles -> narrow -> join
///                                          | batches
///                                    bounded queue
///                                          v
///   narrow arena:   update -> prepare -> tiles -> narrow -> join
///
/// Both arenas have all nodes, so that a thread without work of its own phase goes on with the other's at once; a
/// worker would need 100 us to change arenas. In the narrow arena a thread takes tiles only while no batch waits, in
/// the broad arena it takes batches when no tile is left. A strict split, as in the paper, leaves out the nodes of the
/// other phase:
///
///   broad arena:    update -> prepare -> tiles -> join
///   narrow arena:   update -> narrow -> join
class FlowGraphExecutor final : public Executor, private Delivery {
 public:
  explicit FlowGraphExecutor(const ExecutorOptions& options)
      : options_(options),
        strict_(options.balance.strict),
        frame_(with_short_steps(options), strict_, true),
        awake_(options.stay_awake) {}

  void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
           Timeline* timeline) override {
    const int threads = tbb_threads(wished_threads(options_));
    const bool shared = frame_.begin({work, contacts, report, std::move(stop), timeline}, threads, host_cancellation());
    if (shared) {
      resize(threads);
      report.split = split_;
      narrow_->put(split_.narrow);
      broad_->put(split_.broad);
      awake_.dismiss();
      broad_->wait();
      narrow_->wait();
    }
    frame_.end(work, report);
    if (shared) frame_.balance(*balancer_, report, timeline);
    stay_awake(report, timeline);
  }
  std::size_t memory() const override { return frame_.memory(); }

 private:
  /// The shortest step that is shared, in milliseconds: workers that are awake arrive in a tenth of the time that
  /// waking takes, so shorter steps are worth sharing.
  static ExecutorOptions with_short_steps(ExecutorOptions options) {
    constexpr double of_asleep = 0.1;
    if (options.stay_awake > 0) options.sharing.short_step_ms *= of_asleep;
    return options;
  }

  // ---- The nodes of a step

  /// The graph of one phase: the nodes of a step, in an arena limited to the phase's number of threads. A message has
  /// no content: there is one for each thread, which takes it through all nodes.
  struct PhaseGraph {
    using Node = function_node<continue_msg, continue_msg>;

    /// A node's body, isolated: a user's callback may wait for tasks of its own, and must not be given another message
    /// meanwhile, which would wait for the tile that this thread holds.
    template <class Stage>
    static auto body(Stage stage) {
      return [stage](continue_msg message) noexcept {
        tbb::this_task_arena::isolate(stage);
        return message;
      };
    }

    /// The nodes' bodies are functions of the executor, which also makes the edges.
    PhaseGraph(Phase phase, int threads, FlowGraphExecutor& executor)
        : arena(threads, 1),
          context(tbb::task_group_context::isolated),
          graph(context),
          update(graph, unlimited, body([&] { executor.update(); })),
          prepare(graph, unlimited, body([&] { executor.prepare(); })),
          tiles(graph, unlimited, body([&executor, phase] { executor.tiles(phase); })),
          narrow(graph, unlimited, body([&] { executor.narrow(); })),
          join(graph, unlimited, body([&] { executor.join(); })) {
      attach();
    }

    /// Changes the number of threads; only between steps.
    void resize(int threads) {
      if (threads == arena.max_concurrency()) return;
      arena.terminate();
      arena.initialize(threads, 1);
      attach();
    }

    /// Puts a message for each of so many threads.
    void put(int threads) {
      for (int i = 0; i < threads; ++i) update.try_put({});
    }
    /// Waits for all messages; the calling thread works on them, too.
    void wait() {
      arena.execute([this] { graph.wait_for_all(); });
    }

    tbb::task_arena arena;
    // An isolated context: the caller's may be cancelled, or end, before this graph does, and a step that lost messages
    // would hang.
    tbb::task_group_context context;
    tbb::flow::graph graph;
    Node update, prepare, tiles, narrow, join;

   private:
    /// Ties the graph to the arena: messages go to the arena in which the graph was reset last, whoever sends them.
    void attach() {
      arena.execute([this] { graph.reset(); });
    }
  };

  // ---- Before a step: split, arenas, edges and queue

  void resize(int threads) {
    if (!balancer_ || threads != threads_) {
      threads_ = threads;
      balancer_.emplace(threads, fixed_split(threads), options_.balance.rule, options_.balance.own_rule);
      queue_.set_capacity(queue_capacity(threads));
    }
    if (const Split next = balancer_->split(); next != split_) {
      awake_.end();
      split_ = next;
    }
    // The caller works in the broad arena and then joins the narrow one: together they ask for threads - 1 workers.
    const int broad_slots = split_.broad, narrow_slots = split_.narrow + 1;
    if (!broad_) {
      broad_.emplace(Phase::broad, broad_slots, *this);
      narrow_.emplace(Phase::narrow, narrow_slots, *this);
      make_edges();
    }
    broad_->resize(broad_slots);
    narrow_->resize(narrow_slots);
  }

  void make_edges() {
    if (strict_) {
      make_edge(broad_->update, broad_->prepare);
      make_edge(broad_->prepare, broad_->tiles);
      make_edge(broad_->tiles, broad_->join);
      make_edge(narrow_->update, narrow_->narrow);
      make_edge(narrow_->narrow, narrow_->join);
      return;
    }
    for (PhaseGraph* phase : {&*broad_, &*narrow_}) {
      make_edge(phase->update, phase->prepare);
      make_edge(phase->prepare, phase->tiles);
      make_edge(phase->tiles, phase->narrow);
      make_edge(phase->narrow, phase->join);
    }
  }

  /// The process's limit may leave fewer threads than a fixed split asks for; its proportion is kept then.
  Split fixed_split(int threads) const {
    Split fixed = options_.balance.split;
    if (!fixed.dynamic() && fixed.broad + fixed.narrow != threads) {
      fixed.broad = std::clamp(fixed.broad * threads / (fixed.broad + fixed.narrow), 1, threads - 1);
      fixed.narrow = threads - fixed.broad;
    }
    return fixed;
  }

  std::size_t queue_capacity(int threads) const {
    // A strict producer must neither help nor wait, so its queue never gets full: the paper's array.
    if (strict_) return std::size_t{1} << 30;
    return options_.batches.queue_capacity != 0 ? options_.batches.queue_capacity : usual_queue_capacity(threads);
  }

  // ---- A step: the bodies of the nodes

  void update() { run_stages(state_, 1); }

  void prepare() { run_stages(state_, state_.shared_stage()); }

  /// Fills batches from tiles until none is left.
  void tiles(Phase phase) {
    const std::size_t stage = state_.shared_stage();
    BatchWriter writer(state_, *this);
    while (!state_.all_taken(stage)) {
      if (state_.help() || (phase == Phase::narrow && narrow_one())) continue;
      if (std::size_t tile; state_.take(stage, tile)) state_.run_tile(tile, writer);
    }
    writer.flush();
    if (strict_) watch_narrow();
  }

  /// Puts a full batch into the queue; while that is full, narrows a batch out of it.
  void deliver(Batch& batch) override {
    while (!queue_.try_push(batch)) narrow_one();
    state_.count_queue(queue_.size());
    state_.wake();
  }

  /// Narrows batches until the last one is answered.
  void narrow() {
    at_batches_.fetch_add(1);
    for (std::size_t stage = state_.stage(); stage <= state_.shared_stage(); stage = state_.stage())
      state_.wait_while(stage, [this] { return narrow_one(); });
    at_batches_.fetch_sub(1);
  }

  bool narrow_one() {
    Batch* batch = nullptr;
    if (!queue_.try_pop(batch)) return false;
    state_.process(*batch);
    return true;
  }

  void join() { run_stages(state_, state_.end_stage()); }

  /// For a strict split: a broad thread without tiles does nothing more, unless the scheduler grants the narrow arena
  /// no worker, as under a limit of one thread. The step must end, so it then takes the batches after all.
  void watch_narrow() {
    constexpr auto patience = std::chrono::microseconds(500);
    for (auto check = Clock::now() + patience; state_.stage() == state_.shared_stage(); std::this_thread::yield()) {
      if (Clock::now() < check) continue;
      while (at_batches_.load() == 0 && narrow_one()) continue;
      check = Clock::now() + patience;
    }
  }

  // ---- After a step

  /// Keeps the workers of the next step awake, if that step is to be shared.
  void stay_awake(ExecutionReport& report, Timeline* timeline) {
    if (options_.stay_awake == 0) return;
    report.awake_ms = awake_.take_ms();
    if (timeline != nullptr) timeline->count("awake between steps, ms", report.awake_ms);
    awake_.dismiss();
    // A step that one thread does alone is never shared: nobody would take the spinning tasks, and more would wait
    // after each step.
    if (!broad_ || report.threads == 1 || !frame_.shares_next()) return;
    awake_.keep(broad_->arena, split_.broad - 1);
    awake_.keep(narrow_->arena, split_.narrow);
  }

  ExecutorOptions options_;
  bool strict_;
  StepFrame frame_;
  StepState& state_ = frame_.state();
  std::optional<Balancer> balancer_;
  int threads_ = 0;
  Split split_;
  BatchQueue queue_;
  std::atomic<int> at_batches_{0};            // threads in the nodes `narrow`
  std::optional<PhaseGraph> broad_, narrow_;  // after what the nodes' bodies use
  AwakeWorkers awake_;                        // last: its tasks are in the arenas
};

}  // namespace

std::unique_ptr<Executor> make_flowgraph_executor(const ExecutorOptions& options) {
  return std::make_unique<FlowGraphExecutor>(options);
}

}  // namespace tandem
