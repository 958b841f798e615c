// The paper's Figures 3 to 7 (Avril, Gouranton, Arnaldi, ICAT 2010): measured on this machine's cores, simulated for
// more.
#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>

#include "at_once.h"
#include "benches.h"
#include "contest.h"
#include "machine_costs.h"
#include "progress.h"
#include "simulator.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/response.h"
#include "tandem/flowgraph/measured_step.h"
#include "tandem/flowgraph/timeline.h"

namespace tandem::bench {
namespace {

using nlohmann::json;

constexpr int virtual_cores[] = {4, 8, 16, 32, 64};

double to_tenths_of_us(double ms) { return std::round(1e4 * ms) / 1e4; }
std::string written(Split split) { return fmt::format("{}-{}", split.broad, split.narrow); }

json written(const BalanceDecision& decision) {
  return {{"step", decision.step},
          {"action", name(decision.action)},
          {"reason", decision.reason},
          {"before", written(decision.before)},
          {"after", written(decision.after)},
          {"control_step", decision.control_step},
          {"broad_ms", to_tenths_of_us(decision.broad_ms)},
          {"narrow_ms", to_tenths_of_us(decision.narrow_ms)},
          {"measure", decision.measure},
          {"measure_before", decision.measure_before}};
}

/// A contestant's time at every step, measured or simulated.
struct Series {
  std::string contestant;
  bool is_strict_split = false;  ///< a fixed split, among which the oracle chooses
  std::vector<double> ms;
  std::vector<int> broad_threads;
  std::vector<BalanceDecision> decisions;

  double sum() const { return std::accumulate(ms.begin(), ms.end(), 0.0); }
  void add(double step_ms, Split split, const BalanceDecision& decision) {
    ms.push_back(step_ms);
    broad_threads.push_back(split.broad);
    if (decision.action != BalanceAction::none) decisions.push_back(decision);
  }
};

/// All contestants on one scene with one number of threads.
struct Picture {
  std::string workload;
  std::uint64_t bodies = 0;
  int threads = 1;
  bool simulated = false;
  double slowdown = 1, sharing = 1;
  std::vector<Series> series;

  const Series* find(std::string_view contestant) const {
    const auto at =
        std::find_if(series.begin(), series.end(), [&](const Series& s) { return s.contestant == contestant; });
    return at == series.end() ? nullptr : &*at;
  }
  /// The time of the best fixed strict split of each step; empty without any.
  std::vector<double> oracle() const {
    std::vector<double> best;
    for (const Series& one : series) {
      if (!one.is_strict_split) continue;
      if (best.empty()) best.assign(one.ms.size(), 1e300);
      for (std::size_t step = 0; step < best.size(); ++step) best[step] = std::min(best[step], one.ms[step]);
    }
    return best;
  }
};

/// The recording of a scene: the cost of every piece of every step, and how much threads that work at the same time
/// slow each other down.
struct Recording {
  std::vector<MeasuredForms> steps;
  int rounds = 1;                    ///< rounds of each step by every contestant
  double slowdown = 1, sharing = 1;  ///< as in MachineCosts
};

struct FigureEntrant {
  Contestant contestant;
  bool is_strict_split = false;
};

PipelineOptions papers(ExecutorKind executor, int threads) {
  PipelineOptions options;
  options.executor = executor;
  options.threads = threads;
  options.broad_phase = BroadPhaseKind::brute;
  return options;
}

std::vector<FigureEntrant> entrants(int threads, bool every_split) {
  std::vector<FigureEntrant> all{{{"sequential", papers(ExecutorKind::sequential, 1), {}}}};
  for (const ExecutorKind kind : {ExecutorKind::barrier, ExecutorKind::fused, ExecutorKind::threads})
    all.push_back({{std::string(name(kind)), papers(kind, threads), {}}});
  all.push_back({{"flowgraph", papers(ExecutorKind::flowgraph, threads), {}}});
  for (const BalanceRule rule : {BalanceRule::paper, BalanceRule::busy}) {
    FigureEntrant strict{{fmt::format("strict, {} rule", name(rule)), papers(ExecutorKind::flowgraph, threads), {}}};
    strict.contestant.options.balance.strict = true;
    strict.contestant.options.balance.rule = rule;
    all.push_back(std::move(strict));
  }
  for (int broad = 1; every_split && broad < threads; ++broad) {
    const Split split{broad, threads - broad};
    FigureEntrant fixed{{fmt::format("strict {}", written(split)), papers(ExecutorKind::flowgraph, threads), {}}, true};
    fixed.contestant.options.balance.split = split;
    fixed.contestant.options.balance.strict = true;
    all.push_back(std::move(fixed));
  }
  return all;
}

struct MeasuredScene {
  Picture picture;
  Recording recording;
};

/// The forms of a step whose pieces are recorded.
constexpr StepForm forms[] = {StepForm::caller, StepForm::overlapped, StepForm::ordered};

double busy_of(const ExecutionReport& execution) { return execution.broad_ms + execution.narrow_ms; }

/// Runs a scene with all contestants in turn, and records the costs of its pieces.
class SceneMeasurement {
 public:
  SceneMeasurement(const Scene& scene, std::string_view name, std::vector<FigureEntrant> entrants, int threads,
                   int rounds, std::vector<Row>& rows)
      : name_(name),
        bodies_(scene.bodies()),
        copies_(std::min(threads, tbb::info::default_concurrency())),
        all_(std::move(entrants)),
        rows_(rows),
        result_{{std::string(name), bodies_, threads, false, 1, 1, {}}, {}} {
    result_.recording.rounds = rounds;
    for (const FigureEntrant& entrant : all_)
      result_.picture.series.push_back({entrant.contestant.name, entrant.is_strict_split, {}, {}, {}});
    start_step();
  }

  /// All executors, then the copies, then a recorder of each form.
  std::vector<Contestant> contestants() {
    std::vector<Contestant> contestants;
    for (const FigureEntrant& entrant : all_) contestants.push_back(entrant.contestant);
    contestants.push_back({copies_name(copies_), papers(ExecutorKind::sequential, 1), nullptr, copies_});
    for (std::size_t i = 0; i < std::size(forms); ++i) {
      PipelineOptions recorded = papers(ExecutorKind::sequential, 1);
      // Pieces of 32 pairs: small enough to make up batches of any size, while smaller ones cost more than their pairs.
      // Heavy pairs are one piece each.
      if (forms[i] != StepForm::caller) recorded.batches.pairs = 32;
      recorded.sharing.form = forms[i];
      contestants.push_back({fmt::format("recorder, {}", tandem::name(forms[i])), recorded, &timelines_[i]});
    }
    return contestants;
  }

  void add(const Turn& turn) {
    if (turn.contestant < all_.size())
      add_entrant(turn);
    else if (turn.contestant == all_.size())
      copy_.add(copies_ * turn.report.execution.detect_ms);
    else
      add_recorded(turn.contestant - all_.size() - 1, turn.report.execution);
  }

  void end_step(int step) {
    for (std::size_t i = 1; i < all_.size(); ++i)
      for (std::size_t form = 1; form < std::size(forms); ++form)  // without the caller's form
        if (!all_[i].contestant.options.balance.strict && cells_[i].busy[form].size() != 0)
          busy_ms_ += cells_[i].busy[form].median(), recorded_busy_ms_ += recorded_busy_[form].median();
    for (std::size_t i = 0; i < all_.size(); ++i) {
      Cell& cell = cells_[i];
      cell.row.n = bodies_;
      cell.row.more["step"] = step;
      result_.picture.series[i].add(1e-6 * cell.row.time.median(), cell.split, cell.decision);
      rows_.push_back(std::move(cell.row));
    }
    copies_ms_ += copy_.median();
    alone_ms_ += result_.picture.series.front().ms.back();
    result_.recording.steps.push_back(
        {typical_step(std::move(runs_[0])), typical_step(std::move(runs_[1])), typical_step(std::move(runs_[2]))});
    start_step();
  }

  MeasuredScene result() && {
    Recording& recording = result_.recording;
    recording.slowdown = std::max(1.0, copies_ms_ / alone_ms_);
    if (recorded_busy_ms_ > 0) recording.sharing = std::max(1.0, busy_ms_ / recorded_busy_ms_ / recording.slowdown);
    return std::move(result_);
  }

 private:
  using ByForm = std::array<Samples, std::size(forms)>;
  struct Cell {
    Row row;
    ByForm busy;
    Split split;
    BalanceDecision decision;
  };

  void start_step() {
    cells_.clear();
    for (auto& form : runs_) form.clear();
    recorded_busy_ = {};
    copy_ = {};
    for (const FigureEntrant& entrant : all_)
      cells_.push_back({{"figures", name_, entrant.contestant.name, 1, bodies_, {}, 0, json::object()}, {}, {}, {}});
  }
  void add_recorded(std::size_t form, const ExecutionReport& execution) {
    auto& slices = timelines_[form].lane().slices;
    runs_[form].push_back(read_step(slices, forms[form]));
    slices.clear();
    recorded_busy_[form].add(busy_of(execution));
  }
  void add_entrant(const Turn& turn) {
    Cell& cell = cells_[turn.contestant];
    const ExecutionReport& execution = turn.report.execution;
    cell.row.time.add(1e6 * execution.detect_ms);
    const auto form = static_cast<std::size_t>(std::find(forms, std::end(forms), execution.form) - forms);
    cell.busy[form].add(busy_of(execution));
    cell.row.threads = execution.threads;
    cell.row.hash = turn.report.contact_hash;
    cell.row.more["candidate_pairs"] = execution.candidate_pairs;
    cell.row.more["control_step"] = execution.decision.control_step;
    if (cell.row.time.size() == 1) {
      cell.split = execution.split;
      cell.row.more["split"] = written(execution.split);
    }
    // The pipeline has taken more steps than the scene: one a round.
    if (execution.decision.action != BalanceAction::none) {
      cell.decision = execution.decision;
      cell.decision.step = static_cast<std::uint64_t>(turn.step);
    }
  }

  std::string name_;
  std::uint64_t bodies_;
  int copies_;
  std::vector<FigureEntrant> all_;
  std::vector<Row>& rows_;
  MeasuredScene result_;
  Timeline timelines_[std::size(forms)];
  // Values of the present step.
  std::vector<Cell> cells_;
  std::vector<MeasuredStep> runs_[std::size(forms)];
  ByForm recorded_busy_;
  Samples copy_;
  // Sums over all steps.
  double copies_ms_ = 0, alone_ms_ = 0, busy_ms_ = 0, recorded_busy_ms_ = 0;
};

/// Runs the scene with all contestants in turn, and records the costs of its pieces.
MeasuredScene measure(std::string_view scene_name, int threads, bool every_split, const Settings& settings,
                      std::vector<Row>& rows) {
  Scene scene = make_builtin_scene(scene_name, settings.bodies);
  const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 60 : 300;
  const int rounds = settings.repeat != 0 ? settings.repeat : settings.quick ? 1 : 3;
  SceneMeasurement measurement(scene, scene_name, entrants(threads, every_split), threads, rounds, rows);
  Progress progress(scene_name, steps);
  contest(
      std::move(scene), measurement.contestants(), {steps, rounds}, [&](const Turn& turn) { measurement.add(turn); },
      [&](int step) {
        measurement.end_step(step);
        progress.at(step + 1);
      });
  return std::move(measurement).result();
}

/// The contestants on virtual cores; all strict splits, if asked for. Each detects every step `rounds` times, like
/// those that are measured: a trial of a form costs one turn, not a step of the scene.
Picture simulate(const MeasuredScene& measured, int threads, bool every_split, int rounds, MachineCosts costs) {
  costs.slowdown = measured.recording.slowdown;
  costs.sharing = measured.recording.sharing;
  struct Virtual {
    std::string contestant;
    bool is_strict_split;
    Simulator simulator;
  };
  std::vector<Virtual> all{{"sequential", false, {Policy::sequential, 1, {}, BalanceRule::busy, costs}}};
  if (threads > 1) {
    all.push_back({"barrier", false, {Policy::barrier, threads, {}, BalanceRule::busy, costs}});
    all.push_back({"fused", false, {Policy::fused, threads, {}, BalanceRule::busy, costs}});
    all.push_back({"flowgraph", false, {Policy::conserving, threads, {}, BalanceRule::busy, costs}});
    for (const BalanceRule rule : {BalanceRule::paper, BalanceRule::busy})
      all.push_back({fmt::format("strict, {} rule", name(rule)), false, {Policy::strict, threads, {}, rule, costs}});
    for (int broad = 1; every_split && broad < threads; ++broad) {
      const Split split{broad, threads - broad};
      all.push_back(
          {fmt::format("strict {}", written(split)), true, {Policy::strict, threads, split, BalanceRule::busy, costs}});
    }
  }
  Picture picture{measured.picture.workload, measured.picture.bodies, threads, true, costs.slowdown, costs.sharing, {}};
  for (Virtual& one : all) {
    Series& series = picture.series.emplace_back();
    series.contestant = one.contestant;
    series.is_strict_split = one.is_strict_split;
    for (const MeasuredForms& step : measured.recording.steps) {
      Samples ms;
      Split split;
      BalanceDecision decision;
      for (int round = 0; round < rounds; ++round) {
        const SimulatedStep took = one.simulator.step(step);
        ms.add(1e-6 * took.ns);
        if (round == 0) split = took.split;
        if (one.simulator.decision().action != BalanceAction::none) decision = one.simulator.decision();
      }
      decision.step = static_cast<std::uint64_t>(series.ms.size());
      series.add(ms.median(), split, decision);
    }
  }
  return picture;
}

/// Predicted against measured times of the contestants present in both.
json validate(const Picture& real, const Picture& predicted) {
  json out = json::array();
  for (const Series& simulated : predicted.series) {
    const Series* measured = real.find(simulated.contestant);
    if (measured == nullptr || (predicted.threads > 1 && simulated.contestant == "sequential")) continue;
    Samples errors;
    for (std::size_t step = 0; step < simulated.ms.size(); ++step)
      errors.add(std::abs(simulated.ms[step] / measured->ms[step] - 1));
    const double error = simulated.sum() / measured->sum() - 1;
    out.push_back({{"workload", real.workload},
                   {"threads", predicted.threads},
                   {"contestant", simulated.contestant},
                   {"measured_ms", to_tenths_of_us(measured->sum())},
                   {"predicted_ms", to_tenths_of_us(simulated.sum())},
                   {"error", error},
                   {"median_step_error", errors.median()}});
    fmt::print("{:<18} {:>7} {:<22} {:>10.1f} {:>10.1f} {:>+8.1f} % {:>8.1f} %\n", real.workload, predicted.threads,
               simulated.contestant, measured->sum(), simulated.sum(), 100 * error, 100 * errors.median());
  }
  return out;
}

json written(const Picture& picture, const std::vector<std::string>& figures) {
  json out{{"figures", figures},         {"workload", picture.workload},   {"bodies", picture.bodies},
           {"threads", picture.threads}, {"simulated", picture.simulated}, {"slowdown", picture.slowdown},
           {"sharing", picture.sharing}, {"series", json::array()}};
  const auto list = [](const std::vector<double>& ms) {
    json values = json::array();
    for (const double value : ms) values.push_back(to_tenths_of_us(value));
    return values;
  };
  const std::vector<double> oracle = picture.oracle();
  const double oracle_sum = std::accumulate(oracle.begin(), oracle.end(), 0.0);
  const Series* sequential = picture.find("sequential");
  if (!oracle.empty()) {
    out["oracle_ms"] = list(oracle);
    out["oracle_sum_ms"] = to_tenths_of_us(oracle_sum);
  }
  for (const Series& one : picture.series) {
    json line{{"contestant", one.contestant}, {"sum_ms", to_tenths_of_us(one.sum())}};
    if (sequential != nullptr) line["speedup"] = sequential->sum() / one.sum();
    if (!oracle.empty()) line["over_oracle"] = one.sum() / oracle_sum;
    line["strict_split"] = one.is_strict_split;
    // For the many strict splits of many cores, the sums and the oracle are enough.
    if (!one.is_strict_split || picture.threads <= 8) line["ms"] = list(one.ms);
    if (!one.is_strict_split) {
      line["broad_threads"] = one.broad_threads;
      line["decisions"] = json::array();
      for (const BalanceDecision& decision : one.decisions) line["decisions"].push_back(written(decision));
    }
    out["series"].push_back(std::move(line));
  }
  return out;
}

void print(const Picture& picture) {
  const std::vector<double> oracle = picture.oracle();
  const double oracle_sum = std::accumulate(oracle.begin(), oracle.end(), 0.0);
  fmt::print("\n{}, {} {} threads; sum over {} steps\n", picture.workload, picture.threads,
             picture.simulated ? "simulated" : "real", picture.series.front().ms.size());
  fmt::print("{:<28} {:>10} {:>8} {:>12}\n", "", "ms", "speedup", oracle.empty() ? "" : "over oracle");
  const double sequential = picture.find("sequential")->sum();
  const auto line = [&](const std::string& name, double sum) {
    fmt::print("{:<28} {:>10.1f} {:>7.2f}x {:>12}\n", name, sum, sequential / sum,
               oracle.empty() ? "" : fmt::format("{:.3f}", sum / oracle_sum));
  };
  if (!oracle.empty()) line("best strict split a step", oracle_sum);
  for (const Series& one : picture.series)
    if (!one.is_strict_split || picture.threads <= 8) line(one.contestant, one.sum());
}

/// Figure 4 of the paper: one simulation that switches between sequential and parallel every few steps.
json figure_4(const Settings& settings, int threads, std::vector<Row>& rows) {
  const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 60 : 300;
  const int every = std::max(1, steps / 6);
  json pictures = json::array();
  fmt::print("\nFigure 4: switching every {} steps, {} threads; ms a step in the median of each stretch\n", every,
             threads);
  for (const BuiltinScene& builtin : builtin_scenes().first(4)) {
    Scene scene = make_builtin_scene(builtin.name, settings.bodies);
    const double margin = recommended_margin(scene);
    std::vector<Pipeline> pipelines;
    for (const ExecutorKind kind : {ExecutorKind::sequential, ExecutorKind::flowgraph}) {
      PipelineOptions options = papers(kind, threads);
      options.answer.margin = margin;
      options.answer.contact_hash = true;
      pipelines.emplace_back(std::move(options));
    }
    Response response;
    Progress progress(builtin.name, steps);
    json ms = json::array(), modes = json::array();
    std::vector<Samples> stretches(static_cast<std::size_t>((steps + every - 1) / every));
    for (int step = 0; step < steps; ++step) {
      const std::size_t mode = step / every % 2 == 0 ? 0 : 1;
      const StepReport report = pipelines[mode].step(scene);
      const std::string contestant(name(pipelines[mode].options().executor));
      Row row{"figures",           std::string(builtin.name),
              contestant,          report.execution.threads,
              scene.bodies(),      {},
              report.contact_hash, {{"figure", "4"}, {"step", step}, {"split", written(report.execution.split)}}};
      row.time.add(1e6 * report.execution.detect_ms);
      rows.push_back(std::move(row));
      ms.push_back(to_tenths_of_us(report.execution.detect_ms));
      modes.push_back(contestant);
      stretches[static_cast<std::size_t>(step / every)].add(report.execution.detect_ms);
      response.step(scene, pipelines[mode].contacts());
      progress.at(step + 1);
    }
    pictures.push_back({{"figures", {"4"}},
                        {"workload", builtin.name},
                        {"bodies", scene.bodies()},
                        {"threads", threads},
                        {"simulated", false},
                        {"ms", std::move(ms)},
                        {"mode", std::move(modes)}});
    fmt::print("{:<18}", builtin.name);
    for (const Samples& stretch : stretches) fmt::print(" {:>9.3f}", stretch.median());
    fmt::print("\n");
  }
  return pictures;
}

}  // namespace

Findings figures_bench(const Settings& settings) {
  if (!settings.scenes.empty()) throw std::invalid_argument("--scene: each figure has its own scene");
  std::vector<int> threads = settings.threads;
  if (threads.empty()) threads = {std::max(2, tbb::info::default_concurrency())};
  MachineCosts costs = measure_costs().costs();
  struct Plan {
    std::string_view scene;
    bool every_split;
    std::vector<std::string> figures;
  };
  const Plan plans[] = {{"tori-on-plane", false, {"3", "5"}}, {"tori-and-cubes", true, {"3", "6", "7"}}};

  std::vector<Row> rows;
  json pictures = json::array(), validation = json::array();
  for (const int count : threads) {
    if (count < 2) throw std::invalid_argument(fmt::format("--threads: {}, allowed for figures: from 2", count));
    for (const Plan& plan : plans) {
      const std::size_t first_row = rows.size();
      const MeasuredScene measured = measure(plan.scene, count, plan.every_split, settings, rows);
      costs = least(costs, measure_costs().costs());
      for (std::size_t i = first_row; i < rows.size(); ++i) rows[i].more["figure"] = plan.figures.back();
      print(measured.picture);
      pictures.push_back(written(measured.picture, plan.figures));
      fmt::print(
          "\nThe simulator against reality; at once, sequential copies are {:.1f} % slower than alone, "
          "sharing a step costs another {:.1f} %\n",
          100 * (measured.recording.slowdown - 1), 100 * (measured.recording.sharing - 1));
      fmt::print("{:<18} {:>7} {:<22} {:>10} {:>10} {:>10} {:>10}\n", "scene", "threads", "", "measured", "predicted",
                 "error", "a step");
      for (const int real : {1, count})
        for (const json& line :
             validate(measured.picture, simulate(measured, real, plan.every_split, measured.recording.rounds, costs)))
          validation.push_back(line);
      if (count != threads.front()) continue;
      for (const int cores : virtual_cores) {
        if (cores == count) continue;
        const Picture picture = simulate(measured, cores, plan.every_split, 1, costs);
        print(picture);
        pictures.push_back(written(picture, plan.figures));
      }
    }
    for (json& picture : figure_4(settings, count, rows)) pictures.push_back(std::move(picture));
  }
  return {std::move(rows),
          {{"pictures", std::move(pictures)},
           {"validation", std::move(validation)},
           {"costs_ns",
            {{"task", costs.task},
             {"message", costs.message},
             {"wake", costs.wake},
             {"resize", costs.resize},
             {"move", costs.move},
             {"hand_over", costs.hand_over}}}}};
}

}  // namespace tandem::bench
