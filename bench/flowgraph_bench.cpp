// The overhead of executors, and every executor on synthetic loads and on the paper's scenes.
#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <stdexcept>

#include "at_once.h"
#include "benches.h"
#include "clocks.h"
#include "contest.h"
#include "machine_costs.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/flowgraph/executor.h"
#include "tandem/flowgraph/tile_work.h"

namespace tandem::bench {
namespace {

using Clock = std::chrono::steady_clock;

struct LoadRunner {
  std::string name;
  ExecutorOptions options;
  int copies = 1;  ///< with several, as many run at the same time, each with work of its own, on threads of their own
};

struct Load {
  std::string name;
  TileWork::Size size;
  /// Called before each step, for loads that change.
  std::function<void(TileWork&, int)> before_step{};
};

std::vector<LoadRunner> everyone(int threads, const ExecutorOptions& base = {}) {
  std::vector<LoadRunner> all;
  for (const ExecutorKind kind : executor_kinds) {
    if (threads == 1 && kind != ExecutorKind::sequential && kind != ExecutorKind::flowgraph) continue;
    LoadRunner runner{std::string(name(kind)), base};
    runner.options.kind = kind;
    runner.options.threads = threads;
    all.push_back(std::move(runner));
  }
  return all;
}

/// The most that the cores give when nothing is shared: sequential executors, one on each of them at the same time.
LoadRunner copies(int threads) { return {copies_name(threads), {.kind = ExecutorKind::sequential}, threads}; }

/// A runner in a race, with its copies.
class RaceEntry {
 public:
  RaceEntry(const LoadRunner& runner, const TileWork::Size& size) : contacts_(static_cast<std::size_t>(runner.copies)) {
    for (int i = 0; i < runner.copies; ++i) {
      works_.emplace_back(size);
      executors_.push_back(make_executor(runner.options));
    }
    if (runner.copies > 1) crew_ = std::make_unique<AtOnce>(runner.copies);
  }

  ExecutionReport step(const std::function<void(TileWork&)>& before_step) {
    for (TileWork& work : works_) before_step(work);
    std::vector<ExecutionReport> reports(works_.size());
    const auto run = [&](int i) {
      const auto at = static_cast<std::size_t>(i);
      executors_[at]->run(works_[at], contacts_[at], reports[at], {}, nullptr);
    };
    if (!crew_) {
      run(0);
      return reports.front();
    }
    crew_->run(run);
    double rate = 0;  // together the copies do so many steps a millisecond
    for (const ExecutionReport& report : reports) rate += 1 / report.detect_ms;
    reports.front().detect_ms = 1 / rate;
    reports.front().threads = static_cast<int>(works_.size());
    return reports.front();
  }
  const ContactList& contacts() const { return contacts_.front(); }

 private:
  std::vector<TileWork> works_;
  std::vector<std::unique_ptr<Executor>> executors_;
  std::vector<ContactList> contacts_;
  std::unique_ptr<AtOnce> crew_;
};

/// All runners in turn on the same synthetic load; the first one is the baseline, copies of it on all cores show the
/// most that could be gained.
class Race {
 public:
  Race(std::vector<Row>& rows, int cores, bool quick) : rows_(rows), cores_(cores), steps_(quick ? 8 : 30) {}

  void run(const Load& load, std::vector<LoadRunner> runners) {
    runners.insert(runners.begin() + 1, copies(cores_));
    std::vector<RaceEntry> entries;
    std::vector<Row> own;
    std::vector<std::uint64_t> high_water(runners.size());
    for (const LoadRunner& runner : runners) {
      entries.emplace_back(runner, load.size);
      own.push_back(
          {"flowgraph", load.name, runner.name, 1, TileWork(load.size).pairs(), {}, 0, json_of(runner.options)});
    }
    // The first three are not timed: threads start, batch sizes are learnt.
    for (int step = -3; step < steps_; ++step) {
      for (std::size_t turn = 0; turn < runners.size(); ++turn) {
        const std::size_t who = (turn + static_cast<std::size_t>(step + 3)) % runners.size();
        stay_busy(std::chrono::microseconds(300));
        const ExecutionReport report = entries[who].step([&](TileWork& work) {
          if (load.before_step) load.before_step(work, step);
        });
        if (step < 0) continue;
        own[who].time.add(1e6 * report.detect_ms);
        own[who].threads = report.threads;
        own[who].hash = hash(entries[who].contacts());
        high_water[who] = std::max(high_water[who], report.queue_high_water);
      }
    }
    const Row& first = own.front();
    for (const Row& row : own)
      if (row.hash != first.hash)
        throw std::runtime_error(fmt::format("{}: {} found contacts {}, {} found {}", load.name, first.contestant,
                                             hex(first.hash), row.contestant, hex(row.hash)));
    // The ideal: the work of the first runner, which runs on one thread, divided evenly; and what its copies achieved.
    const double alone = first.time.median(), copied = own[1].time.median();
    for (std::size_t i = 0; i < own.size(); ++i) {
      Row& row = own[i];
      const double of_even = row.time.median() * std::min(row.threads, cores_) / alone;
      row.more["of_even_share"] = of_even;
      row.more["of_copies"] = row.time.median() / copied;
      row.more["queue_high_water"] = high_water[i];
      fmt::print("{:<26} {:<26} {:>7} {:>10.3f} {:>10.3f} {:>10.3f} {:>8.2f} {:>9.2f} {:>6}\n", load.name,
                 row.contestant, row.threads, 1e-6 * row.time.median(), 1e-6 * row.time.quantile(0.1),
                 1e-6 * row.time.quantile(0.9), of_even, row.time.median() / copied, high_water[i]);
    }
    std::move(own.begin(), own.end(), std::back_inserter(rows_));
  }

  static void header(std::string_view title) {
    fmt::print("\n{}\n{:<26} {:<26} {:>7} {:>10} {:>10} {:>10} {:>8} {:>9} {:>6}\n", title, "load", "run by", "threads",
               "ms/step", "p10", "p90", "of even", "of copies", "queue");
  }

 private:
  static nlohmann::json json_of(const ExecutorOptions& options) {
    return {{"batch_pairs", options.batches.pairs},
            {"queue_capacity", options.batches.queue_capacity},
            {"form", name(options.sharing.form)},
            {"split", options.balance.split.dynamic()
                          ? "dynamic"
                          : fmt::format("{}-{}", options.balance.split.broad, options.balance.split.narrow)}};
  }

  std::vector<Row>& rows_;
  int cores_, steps_;
};

/// A load of `ns` in all, its broad and narrow phases in the ratio broad:narrow.
Load ratio_load(double ns, double broad, double narrow, std::size_t tiles = 256) {
  constexpr std::size_t pairs = 40;
  const double share = broad / (broad + narrow);
  return {fmt::format("{:.0f}:{:.0f}", broad, narrow),
          {.tiles = tiles,
           .pairs_a_tile = pairs,
           .tile_ns = ns * share / static_cast<double>(tiles),
           .pair_ns = ns * (1 - share) / static_cast<double>(tiles * pairs)}};
}

void add_cost(std::vector<Row>& rows, std::string_view what, const Samples& time, int threads) {
  fmt::print("{:<44} {:>12.1f} {:>12.1f} {:>12.1f}\n", what, time.median(), time.quantile(0.1), time.quantile(0.9));
  rows.push_back({"flowgraph", "costs", std::string(what), threads, 1, time, 0, nlohmann::json::object()});
}

/// Runs steps of an executor; returns what `measure` computes for each.
Samples steps_of(const LoadRunner& runner, const TileWork::Size& size, int steps,
                 const std::function<double(const ExecutionReport&, const Timeline&)>& measure, bool traced = false) {
  TileWork work(size);
  const auto executor = make_executor(runner.options);
  Samples samples;
  ContactList contacts;
  for (int step = -3; step < steps; ++step) {
    Timeline timeline;
    ExecutionReport report;
    stay_busy(std::chrono::microseconds(300));
    executor->run(work, contacts, report, {}, traced ? &timeline : nullptr);
    if (step >= 0) samples.add(measure(report, timeline));
  }
  return samples;
}

/// Runs one executor with and without a timeline, in turn.
void trace_costs(std::vector<Row>& rows, const TileWork::Size& size, int threads, int steps) {
  TileWork work(size);
  const auto executor = make_executor({.threads = threads});
  ContactList contacts;
  Samples off, on;
  for (int step = -6; step < 2 * steps; ++step) {
    const bool traced = step % 2 != 0;
    Timeline timeline;
    ExecutionReport report;
    stay_busy(std::chrono::microseconds(300));
    executor->run(work, contacts, report, {}, traced ? &timeline : nullptr);
    if (step >= 0) (traced ? on : off).add(1e6 * report.detect_ms);
  }
  add_cost(rows, "a step of 4 ms of work, no timeline", off, threads);
  add_cost(rows, "the same with a timeline", on, threads);
}

void costs(std::vector<Row>& rows, int threads, int steps) {
  fmt::print("What it costs, ns\n{:<44} {:>12} {:>12} {:>12}\n", "", "median", "p10", "p90");
  const CostSamples own = measure_costs();
  add_cost(rows, "a task: an empty tile", own.task, 1);
  add_cost(rows, "a message: a batch from thread to thread", own.message, 2);
  add_cost(rows, "a hand-over between spinning threads", own.hand_over, 2);
  add_cost(rows, "a resize of both arenas", own.resize, 2);
  add_cost(rows, "a worker woken after 1.5 ms", own.wake, 2);
  add_cost(rows, "a worker moved to a re-created arena", own.move, 2);
  const auto detect_ns = [](const ExecutionReport& report, const Timeline&) { return 1e6 * report.detect_ms; };
  for (const LoadRunner& runner : everyone(threads)) {
    add_cost(rows, fmt::format("a frame with no work, {}", runner.name),
             steps_of(runner, {.tiles = 1}, steps, detect_ns), threads);
    if (runner.options.kind == ExecutorKind::sequential) continue;
    LoadRunner shared = runner;
    shared.options.sharing.short_step_ms = 0;
    add_cost(rows, fmt::format("the same shared, {}", runner.name), steps_of(shared, {.tiles = 1}, steps, detect_ns),
             threads);
  }
  // The same form throughout, to see what each costs rather than which is chosen.
  std::vector<LoadRunner> forms = everyone(threads, {.sharing = {.form = StepForm::overlapped}});
  forms.push_back({"flowgraph, ordered", {.threads = threads, .sharing = {.form = StepForm::ordered}}});
  // Pairs and batches that cost next to nothing, so that the overhead remains.
  const TileWork::Size light{.tiles = 200, .pairs_a_tile = 128};
  const double pairs = static_cast<double>(light.tiles * light.pairs_a_tile);
  for (const LoadRunner& runner : forms) {
    LoadRunner shared = runner;
    shared.options.sharing.short_step_ms = 0;
    add_cost(rows, fmt::format("a pair without work, {}", runner.name),
             steps_of(shared, light, steps,
                      [&](const ExecutionReport& r, const Timeline&) { return 1e6 * r.detect_ms / pairs; }),
             threads);
    shared.options.batches.pairs = 1;
    add_cost(rows, fmt::format("a batch of one such pair, {}", runner.name),
             steps_of(shared, light, steps,
                      [&](const ExecutionReport& r, const Timeline&) { return 1e6 * r.detect_ms / pairs; }),
             threads);
  }
  const Load even = ratio_load(4e6, 1, 1);
  for (const LoadRunner& runner : forms)
    add_cost(rows, fmt::format("to the first narrow work in 4 ms, {}", runner.name),
             steps_of(
                 runner, even.size, steps,
                 [](const ExecutionReport&, const Timeline& timeline) {
                   Clock::time_point begin = Clock::time_point::max(), first = begin;
                   timeline.each_slice([&](const Timeline::Slice& slice) {
                     begin = std::min(begin, slice.begin);
                     if (slice.name == "narrow") first = std::min(first, slice.begin);
                   });
                   return std::chrono::duration<double, std::nano>(first - begin).count();
                 },
                 true),
             threads);
  trace_costs(rows, even.size, threads, 4 * steps);
}

/// Loads that change, have costly pairs, or are short.
void hard_loads(Race& race, int cores, double work_ns) {
  Race::header("Loads that are hard to balance");
  Load turning = ratio_load(work_ns, 10, 1);
  turning.name = "10:1, turning each 5 steps";
  const double costly_tile = turning.size.tile_ns,
               costly_pair = costly_tile / static_cast<double>(turning.size.pairs_a_tile);
  turning.before_step = [=](TileWork& work, int step) {
    const bool broad = (step + 5) / 5 % 2 == 0;
    work.set_costs(broad ? costly_tile : 0.1 * costly_tile, broad ? 0.1 * costly_pair : costly_pair);
  };
  race.run(turning, everyone(cores));
  for (const bool late : {false, true})
    race.run({late ? "1000x pairs, all at last" : "1000x pairs, all over",
              {.tiles = 256,
               .pairs_a_tile = 40,
               .tile_ns = 3000,
               .pair_ns = 100,
               .big_every = late ? std::size_t{0} : std::size_t{512},
               .big_ns = 100'000,
               .big_from = late ? std::size_t{10'220} : SIZE_MAX}},
             everyone(cores));
  race.run({"steps of 0.2 ms", ratio_load(0.2e6, 1, 1, 32).size}, everyone(cores));
  race.run({"steps of 0.5 ms", ratio_load(0.5e6, 1, 1, 64).size}, everyone(cores));
}

void synthetic(std::vector<Row>& rows, const std::vector<int>& thread_counts, int cores, bool quick) {
  Race race(rows, cores, quick);
  constexpr double work_ns = 4e6;

  Race::header("Broad to narrow work, 4 ms in all");
  for (const auto& [broad, narrow] :
       {std::pair{1., 100.}, {1., 10.}, {1., 3.}, {1., 1.}, {3., 1.}, {10., 1.}, {100., 1.}})
    race.run(ratio_load(work_ns, broad, narrow), everyone(cores));

  Race::header("Numbers of threads, work 1:1");
  for (const int threads : thread_counts) race.run(ratio_load(work_ns, 1, 1), everyone(threads));

  Race::header("Splits, work 1:1");
  const int threads = std::max(cores, 4);
  std::vector<LoadRunner> splits{{"sequential", {.kind = ExecutorKind::sequential}}};
  for (int broad = 1; broad < threads; broad += std::max(1, threads / 8))
    for (const bool strict : {true, false})
      splits.push_back({fmt::format("{} {}-{}", strict ? "strict" : "split", broad, threads - broad),
                        {.threads = threads, .balance = {.split = {broad, threads - broad}, .strict = strict}}});
  race.run(ratio_load(work_ns, 1, 1), splits);

  Race::header("Pairs a batch");
  std::vector<LoadRunner> batches{{"sequential", {.kind = ExecutorKind::sequential}}};
  for (const std::size_t pairs : {1u, 4u, 16u, 64u, 128u, 256u, 1024u})
    for (const StepForm form : {StepForm::overlapped, StepForm::ordered})
      batches.push_back({fmt::format("{}, at most {}", name(form), pairs),
                         {.threads = cores, .batches = {.pairs = pairs}, .sharing = {.form = form}}});
  Load light = ratio_load(work_ns, 1, 1);
  light.size.pairs_a_tile *= 4;  // 50 ns a pair
  light.size.pair_ns /= 4;
  light.name = "1:1, 50 ns a pair";
  race.run(light, batches);

  Race::header("Batches in the queue");
  std::vector<LoadRunner> queues{{"sequential", {.kind = ExecutorKind::sequential}}};
  for (const std::size_t capacity : {1u, 2u, 4u, 16u, 64u, 512u})
    queues.push_back(
        {fmt::format("flowgraph, room for {}", capacity),
         {.threads = cores, .batches = {.queue_capacity = capacity}, .sharing = {.form = StepForm::overlapped}}});
  race.run(ratio_load(work_ns, 1, 1), queues);

  hard_loads(race, cores, work_ns);
}

/// The paper's scenes on this machine's cores: every executor, and the weight of the two phases.
void real(std::vector<Row>& rows, const Settings& settings, int threads) {
  fmt::print("\nReal loads, brute force; sums over the steps\n{:<18} {:<16} {:>7} {:>10} {:>8} {:>9} {:>14}\n", "scene",
             "run by", "threads", "ms", "speedup", "of copies", "broad:narrow");
  const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 20 : 100;
  std::vector<std::string> scenes = settings.scenes;
  if (scenes.empty())
    for (const BuiltinScene& scene : builtin_scenes().first(4)) scenes.emplace_back(scene.name);
  for (const std::string& scene_name : scenes) {
    PipelineOptions papers;
    papers.broad_phase = BroadPhaseKind::brute;
    const std::vector<Contestant> contestants = executors(threads, papers);
    Scene scene = make_builtin_scene(scene_name, settings.bodies);
    std::vector<Row> own;
    for (const Contestant& contestant : contestants)
      own.push_back({"flowgraph", scene_name, contestant.name, 1, scene.bodies(), {}, 0, {{"steps", steps}}});
    double broad = 0, narrow = 0;
    contest(
        std::move(scene), contestants, {.steps = steps, .stretch = 10},
        [&](const Turn& turn) {
          const ExecutionReport& execution = turn.report.execution;
          Row& row = own[turn.contestant];
          row.time.add(1e6 * execution.detect_ms);
          row.threads = execution.threads;
          row.hash = turn.report.contact_hash;
          if (turn.contestant == 0) {
            broad += execution.broad_ms;
            narrow += execution.narrow_ms;
          }
        },
        [](int) {});
    for (Row& row : own) {
      const double speedup = own.front().time.sum() / row.time.sum();
      row.more["speedup_of_sums"] = speedup;
      const double of_copies = row.time.sum() / own[1].time.sum();
      row.more["of_even_share"] = row.threads / speedup;
      row.more["of_copies"] = of_copies;
      row.more["narrow_over_broad"] = narrow / broad;
      fmt::print("{:<18} {:<16} {:>7} {:>10.1f} {:>7.2f}x {:>9.2f} {:>14}\n", scene_name, row.contestant, row.threads,
                 1e-6 * row.time.sum(), speedup, of_copies, fmt::format("1:{:.2f}", narrow / broad));
    }
    for (Row& row : own) rows.push_back(std::move(row));
  }
}

}  // namespace

std::vector<Row> flowgraph_bench(const Settings& settings) {
  const int cores = std::max(2, tbb::info::default_concurrency());
  std::vector<int> threads = settings.threads;
  if (threads.empty())
    for (int count = 1; count <= 2 * cores; count = count < 4 ? count + 1 : 2 * count) threads.push_back(count);
  std::vector<Row> rows;
  costs(rows, cores, settings.quick ? 10 : 60);
  synthetic(rows, threads, cores, settings.quick);
  real(rows, settings, cores);
  return rows;
}

}  // namespace tandem::bench
