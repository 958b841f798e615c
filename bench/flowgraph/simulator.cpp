// An event simulation of the executors' rules on virtual cores.
#include "simulator.h"

#include <algorithm>
#include <array>
#include <deque>
#include <numeric>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include "engine/pipeline/pair_costs.h"

namespace tandem::bench {

/// A virtual core.
struct Simulator::Thread {
  bool broad = true;  // its phase in the split
  double free = 0;    // time from which on it can take work
};

/// The simulated shared stage: tiles that emit pairs and batches that are narrowed.
class Simulator::Shared {
 public:
  /// `costliest_ns`: heavy pairs of at least this cost are begun first.
  Shared(Policy policy, const MachineCosts& costs, const MeasuredStep& work, BatchPairs batch_pairs,
         double costliest_ns, const std::vector<Thread>& threads)
      : policy_(policy),
        costs_(costs),
        sharing_(threads.size() > 1 ? costs.sharing : 1),
        work_(work),
        batch_pairs_(static_cast<double>(batch_pairs.most)),
        costliest_ns_(costliest_ns),
        heavy_most_(policy == Policy::sequential ? 0 : batch_pairs.heavy),
        capacity_(usual_queue_capacity(static_cast<int>(threads.size()))),
        tiles_left_(work.tiles.size()),
        threads_(threads),
        agents_(threads.size()) {}

  /// Runs the stage from this time; returns the time when the last thread is done.
  double run(double from) {
    double first_pair = 0;
    for (const MeasuredStep::Tile& tile : work_.tiles) {
      first_pairs_.push_back(first_pair);
      first_pair += static_cast<double>(tile.pairs);
    }
    for (std::size_t i = 0; i < agents_.size(); ++i) schedule(i, std::max(from, threads_[i].free));
    double end = from;
    while (!events_.empty()) {
      const auto [now, neither, who] = events_.top();
      events_.pop();
      act(who, now);
      end = std::max(end, agents_[who].last_work);
    }
    return end;
  }
  double broad_ns = 0, narrow_ns = 0;
  double heavy_ns = 0;  // time of heavy pairs in the narrow phase
  std::uint64_t heavy_pairs = 0;

 private:
  struct Ready {
    double ns = 0;
    std::uint64_t heavy_pairs = 0;  // 0: a batch of light pairs
    bool costliest = false;
  };
  struct Agent {
    std::size_t tile = 0;
    double tile_pair = 0, tile_end = 0;  // the pairs of the tile in hand that are still to come
    double ns_a_pair = 0;
    bool in_tile = false;
    double batch_pairs = 0, batch_ns = 0;  // the batch in hand, without heavy pairs
    std::vector<double> heavy;             // heavy pairs of the batch in hand
    std::deque<Ready> full;                // full batches that wait for room in the queue
    bool ends_tile = false;                // the tile ends with the work that it is doing
    double last_work = 0;
  };
  using Event = std::tuple<double, std::uint64_t, std::size_t>;  // time, order, thread

  void schedule(std::size_t who, double at) { events_.push({at, order_++, who}); }

  /// The slowdown that the threads now at work cause another one.
  double slowdown(std::size_t who, double now) const {
    std::size_t others = 0;
    for (std::size_t i = 0; i < agents_.size(); ++i) others += i != who && agents_[i].last_work > now ? 1 : 0;
    if (others == 0) return 1;
    return 1 + (costs_.slowdown - 1) * static_cast<double>(others) / static_cast<double>(agents_.size() - 1);
  }

  /// Adds `ns` of work and `overhead` to a thread.
  void work_for(std::size_t who, double now, double ns, double overhead, double& account) {
    const double time = ns * sharing_ * slowdown(who, now) + overhead + costs_.task;
    account += time;
    agents_[who].last_work = now + time;
    schedule(who, now + time);
  }

  void process(std::size_t who, double now, const Ready& batch, double overhead) {
    const double before = narrow_ns;
    work_for(who, now, batch.ns, overhead, narrow_ns);
    if (batch.heavy_pairs == 0) return;
    heavy_ns += narrow_ns - before;
    heavy_pairs += batch.heavy_pairs;
  }

  std::deque<Ready>& queue_of(const Ready& batch) {
    return queues_[batch.costliest ? 0 : batch.heavy_pairs != 0 ? 1 : 2];
  }

  bool pop(std::size_t who, double now) {
    const auto some = std::find_if(queues_.begin(), queues_.end(), [](const auto& one) { return !one.empty(); });
    if (some == queues_.end()) return false;
    auto& queue = *some;
    const Ready batch = queue.front();
    queue.pop_front();
    process(who, now, batch, 0.5 * costs_.message);
    return true;
  }

  bool take_tile(std::size_t who, double now) {
    if (next_tile_ == work_.tiles.size()) return false;
    Agent& agent = agents_[who];
    agent.tile = next_tile_++;
    agent.tile_pair = first_pairs_[agent.tile];
    const auto pairs = static_cast<double>(work_.tiles[agent.tile].pairs);
    agent.tile_end = agent.tile_pair + pairs;
    agent.ns_a_pair = pairs > 0 ? work_.tiles[agent.tile].ns / pairs : 0;
    agent.in_tile = true;
    emit(who, now);
    return true;
  }

  /// Runs the tile in hand up to the next full batch or its end.
  void emit(std::size_t who, double now) {
    Agent& agent = agents_[who];
    const double pairs = std::min(agent.tile_end - agent.tile_pair, batch_pairs_ - agent.batch_pairs);
    const double ns = agent.ns_a_pair > 0 ? agent.ns_a_pair * pairs : work_.tiles[agent.tile].ns;
    const double end = agent.tile_pair + pairs;
    agent.batch_ns += work_.narrow_ns(agent.tile_pair, end, false);
    if (work_.has_heavy())
      for (std::size_t i = work_.piece_of(agent.tile_pair); i < work_.pieces.size() && work_.first_pair(i) < end; ++i)
        if (work_.pieces[i].heavy && work_.first_pair(i) >= agent.tile_pair) agent.heavy.push_back(work_.pieces[i].ns);
    agent.batch_pairs += pairs;
    agent.tile_pair = end;
    if (agent.batch_pairs >= batch_pairs_) hand_on(agent);
    if (agent.tile_pair >= agent.tile_end) {
      agent.in_tile = false;
      agent.ends_tile = true;
      if (policy_ == Policy::fused) hand_on(agent);
    }
    work_for(who, now, ns, 0, broad_ns);
  }

  void hand_on(Agent& agent) const {
    const std::size_t heavy = agent.heavy.size();
    if (heavy_most_ == 0) {
      agent.batch_ns = std::accumulate(agent.heavy.begin(), agent.heavy.end(), agent.batch_ns);
    } else {
      // The executors estimate from the step before which pairs are costliest, and are right for nearly all.
      const auto rest = std::stable_partition(agent.heavy.begin(), agent.heavy.end(),
                                              [this](double ns) { return ns >= costliest_ns_; });
      for (auto at = agent.heavy.begin(), end = at; at != agent.heavy.end(); at = end) {
        const bool costliest = at < rest;
        end = at + std::min(costliest ? 1 : static_cast<std::ptrdiff_t>(heavy_most_), agent.heavy.end() - at);
        agent.full.push_back({std::accumulate(at, end, 0.0), static_cast<std::uint64_t>(end - at), costliest});
      }
    }
    const double others = agent.batch_pairs - (heavy_most_ != 0 ? static_cast<double>(heavy) : 0);
    if (others > 0) agent.full.push_back({agent.batch_ns, 0, false});
    agent.batch_ns = agent.batch_pairs = 0;
    agent.heavy.clear();
  }

  void wake_idle(double now) {
    for (const std::size_t who : std::exchange(idle_, {})) schedule(who, now + costs_.hand_over);
  }

  /// Hands a full batch on; false if the queue was full and the thread narrowed a batch itself.
  bool deliver(std::size_t who, double& now) {
    Agent& agent = agents_[who];
    while (!agent.full.empty()) {
      const Ready batch = agent.full.front();
      if (policy_ == Policy::fused) {
        agent.full.pop_front();
        process(who, now, batch, 0);
        return false;
      }
      if (policy_ == Policy::conserving && queue_of(batch).size() >= capacity_) return !pop(who, now);
      queue_of(batch).push_back(batch);
      agent.full.pop_front();
      now += 0.5 * costs_.message;
      wake_idle(now);
    }
    return true;
  }

  void act(std::size_t who, double now) {
    Agent& agent = agents_[who];
    if (std::exchange(agent.ends_tile, false) && --tiles_left_ == 0) wake_idle(now);
    if (!deliver(who, now)) return;
    if (agent.in_tile) return emit(who, now);
    if (policy_ == Policy::conserving && next_tile_ == work_.tiles.size()) {
      hand_on(agent);
      if (!deliver(who, now)) return;
    }
    const bool broad = threads_[who].broad;
    const bool tiles = broad || policy_ != Policy::strict;
    const bool batches = policy_ == Policy::strict ? !broad : policy_ == Policy::conserving || tiles_left_ == 0;
    const bool batch_first = policy_ == Policy::conserving && !broad;
    if ((batch_first && pop(who, now)) || (tiles && take_tile(who, now)) || (batches && pop(who, now))) return;
    hand_on(agent);
    if (!agent.full.empty()) return schedule(who, now);
    idle_.push_back(who);  // the next batch wakes it, if there is one
  }

  Policy policy_;
  const MachineCosts& costs_;
  double sharing_;
  const MeasuredStep& work_;
  double batch_pairs_, costliest_ns_;
  std::size_t heavy_most_;  // 0: heavy pairs stay among the others
  std::size_t capacity_;
  std::size_t next_tile_ = 0, tiles_left_;
  const std::vector<Thread>& threads_;
  std::vector<Agent> agents_;
  std::vector<double> first_pairs_;
  std::array<std::deque<Ready>, 3> queues_;  // in turn: the costliest batches, other heavy ones, the rest
  std::vector<std::size_t> idle_;
  std::uint64_t order_ = 0;
  std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
};

Simulator::Simulator(Policy policy, int threads, Split fixed, BalanceRule rule, const MachineCosts& costs,
                     StepForm wanted)
    : policy_(policy),
      threads_(policy == Policy::sequential ? 1 : threads),
      costs_(costs),
      balancer_(std::max(2, threads), fixed, rule),
      form_(policy == Policy::strict ? StepForm::overlapped : wanted, small_step_ms, policy != Policy::fused),
      before_(balancer_.split()) {}

// Runs blocks in their order, each on the thread that is free first.
double Simulator::stage(const MeasuredStep::Stage& stage, const std::vector<Thread>& threads, double from,
                        bool narrow_helps) const {
  from += stage.open_ns;
  if (stage.blocks.empty()) return from;
  std::priority_queue<double, std::vector<double>, std::greater<>> free;
  for (const Thread& thread : threads)
    if (thread.broad || narrow_helps) free.push(std::max(from, thread.free));
  const double slowdown = free.size() > 1 && stage.blocks.size() > 1 ? costs_.slowdown * costs_.sharing : 1;
  double end = from;
  for (const double ns : stage.blocks) {
    const double done = free.top() + ns * slowdown + costs_.task;
    free.pop();
    free.push(done);
    end = std::max(end, done);
  }
  return end + (threads.size() > 1 ? costs_.hand_over : 0);
}

// The runs of batches of sorted pairs, those with heavy pairs first.
std::vector<Simulator::OrderedBatch> Simulator::ordered_batches(const MeasuredStep& work) const {
  const BatchPairs size = batch_size_.get(StepForm::ordered);
  std::vector<OrderedBatch> batches;
  if (!work.has_heavy()) {
    const auto all = static_cast<std::size_t>(work.pairs());
    for (std::size_t at = 0, end = 0; at < all; at = end) {
      end = std::min(at + size.most * batches_in_a_row((all - at + size.most - 1) / size.most, size.threads), all);
      batches.push_back({work.narrow_ns(static_cast<double>(at), static_cast<double>(end), false), 0, false});
    }
    return batches;
  }
  const double light_share = 1.0 / static_cast<double>(size.most);
  const double heavy_share = std::max(1.0 / static_cast<double>(std::max<std::size_t>(size.heavy, 1)), light_share);
  double full = 1;
  for (const MeasuredStep::Piece& piece : work.pieces) {
    if (full > 0.999) {
      batches.emplace_back();
      full = 0;
    }
    // A piece of sorted pairs ends with its heavy one.
    full += light_share * static_cast<double>(piece.pairs) + (piece.heavy ? heavy_share - light_share : 0);
    batches.back().ns += piece.ns;
    batches.back().pairs += piece.pairs;
    batches.back().heavy |= piece.heavy;
  }
  std::stable_partition(batches.begin(), batches.end(), [](const OrderedBatch& batch) { return batch.heavy; });
  return batches;
}

/// Runs the tiles, the sorting of pairs, then the narrow batches, a stage each.
double Simulator::ordered_phase(const MeasuredStep& work, const std::vector<Thread>& threads, double now,
                                SimulatedStep& result, ExecutionReport& report) const {
  const double slowdown = costs_.slowdown * costs_.sharing;
  MeasuredStep::Stage tiles, narrow{work.open_narrow_ns, {}};
  for (const MeasuredStep::Tile& tile : work.tiles) tiles.blocks.push_back(tile.ns);
  now = stage(tiles, threads, now, true);
  for (const MeasuredStep::Stage& one : work.order) now = stage(one, threads, now, true);
  for (const OrderedBatch& batch : ordered_batches(work)) {
    narrow.blocks.push_back(batch.ns);
    result.narrow_ns += slowdown * batch.ns;
    if (!batch.heavy) continue;
    report.heavy_ms += 1e-6 * slowdown * batch.ns;
    report.heavy_pairs += batch.pairs;
  }
  now = stage(narrow, threads, now, true);
  for (const double ns : tiles.blocks) result.broad_ns += slowdown * ns;
  return now;
}

SimulatedStep Simulator::step(const MeasuredForms& forms) {
  SimulatedStep result;
  ExecutionReport report;
  report.threads = threads_;
  report.form = threads_ == 1 ? StepForm::caller : form_.next();
  const MeasuredStep& work = forms.in(report.form);
  const bool shared = report.form != StepForm::caller;
  const bool divided = shared && (policy_ == Policy::strict || policy_ == Policy::conserving);
  result.form = report.form;
  result.split = !shared ? Split{1, 0} : divided ? balancer_.split() : Split{threads_, threads_};

  std::vector<Thread> threads(shared ? static_cast<std::size_t>(threads_) : 1);
  double now = work.begin_ns;
  if (divided && !(result.split == before_)) now += costs_.resize;
  for (std::size_t i = 1; i < threads.size(); ++i) {
    const auto broad_threads = static_cast<std::size_t>(result.split.broad);
    threads[i].broad = !divided || i < broad_threads;
    const bool moved = divided && threads[i].broad != (i < static_cast<std::size_t>(before_.broad));
    threads[i].free = now + std::max(costs_.wake, moved ? costs_.move : 0);
  }
  if (divided) before_ = result.split;

  const bool strict = shared && policy_ == Policy::strict;
  for (std::size_t i = 0; i < work.before.size(); ++i) now = stage(work.before[i], threads, now, !strict || i == 0);
  now += work.open_tiles_ns;
  if (report.form == StepForm::ordered) {
    now = ordered_phase(work, threads, now, result, report);
  } else {
    for (const MeasuredStep::Stage& one : work.order) now = stage(one, threads, now, true);
    Shared phase(shared ? policy_ : Policy::sequential, costs_, work, batch_size_.get(report.form),
                 PairCosts::costliest_from(costliest_ns_, batch_size_.get(report.form).time), threads);
    now = phase.run(now);
    result.broad_ns = phase.broad_ns;
    result.narrow_ns = phase.narrow_ns;
    report.heavy_ms = 1e-6 * phase.heavy_ns;
    report.heavy_pairs = phase.heavy_pairs;
  }
  costliest_ns_ = work.costliest_ns();
  const double narrowed = now;
  for (const MeasuredStep::Stage& one : work.after) now = stage(one, threads, now, true);
  report.join_ms = 1e-6 * (now - narrowed);
  for (std::size_t i = 1; i < work.before.size(); ++i)
    for (const double ns : work.before[i].blocks) result.broad_ns += ns;

  result.ns = now;
  report.candidate_pairs = work.pairs();
  report.narrow_ms = 1e-6 * result.narrow_ns;
  report.broad_ms = 1e-6 * result.broad_ns;
  report.detect_ms = 1e-6 * now;
  if (!shared && threads_ > 1) report.issues |= bit(StepIssue::ran_on_caller);
  if (threads_ > 1) form_.learn(report, 1e-6 * work.work_ns(), static_cast<double>(work.pairs()));
  batch_size_.learn(report);
  decision_ = divided ? balancer_.after_step(step_, report) : BalanceDecision{};
  ++step_;
  return result;
}

}  // namespace tandem::bench
