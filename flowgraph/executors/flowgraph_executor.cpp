#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <deque>
#include <optional>
#include <thread>
#include <tuple>

#include "executors/batch_queue.h"
#include "executors/executors.h"
#include "executors/step_frame.h"

// The flowgraph executor: a step as two oneTBB flow graphs, one for the threads of each phase, after the paper's
// pipeline.

namespace tandem {
namespace {

using tbb::flow::continue_msg;
using tbb::flow::function_node;
using tbb::flow::make_edge;
using tbb::flow::multifunction_node;
using tbb::flow::node_priority_t;
using tbb::flow::output_port;
using tbb::flow::unlimited;

/// A thread's turn: it goes through the stages with the batch that its tiles fill.
struct Turn {
  BatchWriter* writer;
};

/// The nodes of a step, in an arena whose limit is the number of threads of one phase. The executor makes the edges.
struct PhaseGraph {
  using Tiles = multifunction_node<Turn, std::tuple<Turn, continue_msg, continue_msg>>;
  enum TilesPort { again, to_narrow, to_join };
  using Narrow = multifunction_node<continue_msg, std::tuple<continue_msg>>;

  /// `body`: has a member for each node. A user's callback may wait for tasks of its own; it must not be given another
  /// message meanwhile, hence the isolation.
  template <class Body>
  PhaseGraph(int threads, Body& body, node_priority_t narrow_priority)
      : arena(threads, 1),
        context(tbb::task_group_context::isolated),
        graph(context),
        update(graph, unlimited, [&](Turn turn) noexcept { return alone([&] { return body.update(turn); }); }),
        prepare(graph, unlimited, [&](Turn turn) noexcept { return alone([&] { return body.prepare(turn); }); }),
        tiles(graph, unlimited, [&](Turn turn, auto& to) noexcept { alone([&] { body.tiles(*this, turn, to); }); }),
        narrow(
            graph, unlimited, [&](continue_msg, auto& to) noexcept { alone([&] { body.narrow(*this, to); }); },
            narrow_priority),
        join(graph, unlimited, [&](continue_msg) noexcept { return alone([&] { return body.join(); }); }) {
    attach();
  }

  /// Between steps.
  void resize(int threads) {
    if (threads == arena.max_concurrency()) return;
    arena.terminate();
    arena.initialize(threads, 1);
    attach();
  }
  /// The caller joins the arena until no message is left.
  void wait() {
    arena.execute([this] { graph.wait_for_all(); });
  }

  tbb::task_arena arena;
  // Not bound to the caller's: that one may end before this graph does, and a step that lost messages would hang.
  tbb::task_group_context context;
  tbb::flow::graph graph;
  function_node<Turn, Turn> update, prepare;
  Tiles tiles;
  Narrow narrow;
  function_node<continue_msg> join;

 private:
  template <class Body>
  static auto alone(Body&& body) {
    return tbb::this_task_arena::isolate(body);
  }
  /// A graph's messages go to the arena in which it was reset last, whoever sends them.
  void attach() {
    arena.execute([this] { graph.reset(); });
  }
};

/// The product. Each phase has an arena, of X and Y threads for the split X-Y, and in it a graph of the step's stages:
///
///   broad arena:    update -> prepare -> tiles -> narrow -> join
///                                          | batches
///                                    bounded queue
///                                          v
///   narrow arena:   update -> prepare -> tiles -> narrow -> join
///
/// The tiles of the broad phase fill batches; each goes into the queue, and a message to the narrow phase's node. The
/// two graphs have the same nodes, so that threads without work of their own phase go on with the other's at once,
/// where a worker needs 100 us to change arenas: the narrow arena's take tiles while no batch waits, the broad arena's
/// take batches when no tile is left. In a strict split, as the paper's, the edges for that are missing.
class FlowGraphExecutor final : public Executor, private Delivery {
 public:
  explicit FlowGraphExecutor(const ExecutorOptions& options)
      : options_(options), strict_(options.balance.strict), frame_(options, strict_, true) {
    state_.on_share([this] { call_helpers(); });
  }

  void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token stop,
           Timeline* timeline) override {
    const Split fixed = options_.balance.split;
    const int threads = tbb_threads(fixed.dynamic() ? options_.threads : fixed.broad + fixed.narrow);
    const bool shared = frame_.begin({work, contacts, report, std::move(stop), timeline}, threads, host_cancellation());
    if (shared) {
      resize(threads);
      report.split = split_;
      send_turns();
      wait();
    }
    frame_.end(work, report);
    if (shared) frame_.balance(*balancer_, report, timeline);
  }

 private:
  friend PhaseGraph;

  // ---- Before a step: arenas, queue and edges

  void resize(int threads) {
    if (!balancer_ || threads != threads_) {
      threads_ = threads;
      balancer_.emplace(threads, fixed_split(threads), options_.balance.rule);
      queue_.set_capacity(queue_capacity(threads));
    }
    split_ = balancer_->split();
    if (!broad_) {
      broad_.emplace(split_.broad, *this, tbb::flow::no_priority);
      narrow_.emplace(narrow_slots(), *this, node_priority_t{1});  // batches before the tiles of the other phase
      connect();
    }
    broad_->resize(split_.broad);
    narrow_->resize(narrow_slots());
    Delivery& into_queue = *this;
    while (writers_.size() < static_cast<std::size_t>(threads)) writers_.emplace_back(state_, into_queue);
  }

  void connect() {
    for (PhaseGraph* phase : {&*broad_, &*narrow_}) {
      const bool broad = phase == &*broad_;
      if (broad || !strict_) {
        make_edge(phase->update, phase->prepare);
        make_edge(phase->prepare, phase->tiles);
        make_edge(output_port<PhaseGraph::again>(phase->tiles), phase->tiles);
      }
      if (!strict_) make_edge(output_port<PhaseGraph::to_narrow>(phase->tiles), phase->narrow);
      make_edge(output_port<PhaseGraph::to_join>(phase->tiles), phase->join);
      make_edge(output_port<0>(phase->narrow), phase->join);
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

  /// The caller works in the broad arena first and then joins the narrow one: together they ask for threads - 1
  /// workers.
  int narrow_slots() const { return split_.narrow + 1; }

  // ---- A step: its messages, and the bodies of the nodes

  void send_turns() {
    called_to_join_.store(false, std::memory_order_relaxed);
    for (int i = 0; i < threads_; ++i) {
      PhaseGraph& phase = i < split_.narrow ? *narrow_ : *broad_;
      phase.update.try_put({&writers_[static_cast<std::size_t>(i)]});
    }
  }

  void wait() {
    for (bool finished = false; !finished;) {
      finished = state_.finished();
      broad_->wait();
      if (strict_) watch_narrow();
      narrow_->wait();
    }
    broad_->wait();  // for messages of the narrow arena that came too late
  }

  Turn update(Turn turn) {
    run_stages(state_, 1);
    return turn;
  }

  Turn prepare(Turn turn) {
    run_stages(state_, state_.shared_stage());
    return turn;
  }

  /// One tile, and the turn comes again; without a tile its pairs leave, and it goes on with the batches that wait.
  template <class Ports>
  void tiles(PhaseGraph& phase, Turn turn, Ports& to) {
    while (state_.help()) continue;
    if (std::size_t tile; state_.take(state_.shared_stage(), tile)) {
      state_.run_tile(tile, *turn.writer);
      std::get<PhaseGraph::again>(to).try_put(turn);
      return;
    }
    turn.writer->flush();
    std::get<PhaseGraph::to_narrow>(to).try_put({});
    go_on(phase, std::get<PhaseGraph::to_join>(to));
  }

  /// A full batch from a writer goes into the queue, or, when that is full, another one out of it.
  void deliver(Batch& batch) override {
    for (Batch* other = nullptr; !queue_.try_push(batch);)
      if (queue_.try_pop(other)) state_.process(*other);
    state_.count_queue(queue_.size());
    const bool told = state_.guard([this] {
      narrow_->narrow.try_put({});
      if (!strict_ && state_.all_taken(state_.shared_stage())) broad_->narrow.try_put({});
    });
    if (!told) narrow_all();  // the batch is in the queue all the same
  }

  template <class Ports>
  void narrow(PhaseGraph& phase, Ports& to) {
    at_work_.fetch_add(1);
    narrow_all();
    at_work_.fetch_sub(1);
    go_on(phase, std::get<0>(to));
  }

  void narrow_all() {
    for (;;) {
      Batch* batch = nullptr;
      if (state_.help()) continue;
      if (!queue_.try_pop(batch)) return;
      state_.process(*batch);
    }
  }

  /// Whoever sees that the shared stage is over calls all threads to the stages that follow: those of its own arena by
  /// the edge, the others by a message, as the successor of an edge runs in the arena of its source.
  template <class Port>
  void go_on(PhaseGraph& phase, Port& to_join) {
    if (state_.stage() == state_.shared_stage() || called_to_join_.exchange(true)) return;
    const bool is_broad = &phase == &*broad_;
    PhaseGraph& other = is_broad ? *narrow_ : *broad_;
    for (int i = 0; i < (is_broad ? narrow_slots() : split_.broad); ++i) other.join.try_put({});
    for (int i = 0; i < (is_broad ? split_.broad : narrow_slots()); ++i) to_join.try_put({});
  }

  continue_msg join() {
    run_stages(state_, state_.end_stage());
    return {};
  }

  /// Parts of a batch are there to share.
  void call_helpers() {
    for (int i = 0; i < split_.broad; ++i) broad_->narrow.try_put({});
    for (int i = 0; i < narrow_slots(); ++i) narrow_->narrow.try_put({});
  }

  /// In a strict split the caller takes no batch. But where the scheduler grants the narrow arena no worker, as under a
  /// limit of one thread, the step must still end: then it joins that arena after all.
  void watch_narrow() {
    constexpr auto patience = std::chrono::microseconds(500);
    for (auto end = Clock::now() + patience; state_.stage() == state_.shared_stage(); std::this_thread::yield()) {
      if (at_work_.load() != 0) end = Clock::now() + patience;
      if (Clock::now() > end) return;
    }
  }

  ExecutorOptions options_;
  bool strict_;
  StepFrame frame_;
  StepState& state_ = frame_.state();
  std::optional<Balancer> balancer_;
  int threads_ = 0;
  Split split_;
  BatchQueue queue_;
  std::deque<BatchWriter> writers_;  // one a turn
  std::atomic<int> at_work_{0};      // on batches, in the bodies of `narrow`
  std::atomic<bool> called_to_join_{false};
  std::optional<PhaseGraph> broad_, narrow_;  // last: their bodies use what is above
};

}  // namespace

std::unique_ptr<Executor> make_flowgraph_executor(const ExecutorOptions& options) {
  return std::make_unique<FlowGraphExecutor>(options);
}

}  // namespace tandem
