#include <fmt/format.h>
#include <oneapi/tbb/info.h>

#include <algorithm>

#include "benches.h"
#include "contest.h"
#include "progress.h"
#include "tandem/engine/builtin_scenes.h"

namespace tandem::bench {
namespace {

/// Every contestant's time at every step.
struct Curves {
  std::vector<Contestant> contestants;
  std::vector<std::vector<Row>> at_step;  ///< [step][contestant]

  double median(std::size_t step, std::size_t contestant) const { return at_step[step][contestant].time.median(); }
  double sum(std::size_t contestant) const {
    double all = 0;
    for (std::size_t step = 0; step < at_step.size(); ++step) all += median(step, contestant);
    return all;
  }
};

Curves run(std::string_view figure, std::string_view scene_name, std::vector<Contestant> contestants,
           const Settings& settings) {
  Scene scene = make_builtin_scene(scene_name, settings.bodies);
  const auto steps = static_cast<std::size_t>(settings.steps != 0 ? settings.steps : settings.quick ? 120 : 600);
  const int repeat = settings.repeat != 0 ? settings.repeat : settings.quick ? 1 : 3;
  Curves curves{std::move(contestants), {}};
  for (std::size_t step = 0; step < steps; ++step) {
    std::vector<Row>& rows = curves.at_step.emplace_back();
    for (const Contestant& contestant : curves.contestants)
      rows.push_back({"figures",
                      std::string(scene_name),
                      contestant.name,
                      1,
                      scene.bodies(),
                      {},
                      0,
                      {{"figure", figure}, {"step", step}}});
  }
  Progress progress(figure, steps);
  contest(
      std::move(scene), curves.contestants, static_cast<int>(steps), repeat,
      [&](const Turn& turn) {
        Row& row = curves.at_step[static_cast<std::size_t>(turn.step)][turn.contestant];
        const ExecutionReport& execution = turn.report.execution;
        row.time.add(1e6 * execution.detect_ms);
        row.threads = execution.threads;
        row.hash = turn.report.contact_hash;
        row.more["split"] = fmt::format("{}-{}", execution.split.broad, execution.split.narrow);
        row.more["control_step"] = execution.decision.control_step;
        row.more["candidate_pairs"] = execution.candidate_pairs;
      },
      [&](int step) { progress.at(static_cast<std::uint64_t>(step) + 1); });
  return curves;
}

void append(std::vector<Row>& rows, Curves& curves) {
  for (auto& step : curves.at_step)
    for (Row& row : step) rows.push_back(std::move(row));
}

PipelineOptions papers(ExecutorKind executor, int threads) {
  PipelineOptions options;
  options.executor = executor;
  options.threads = threads;
  options.broad_phase = BroadPhaseKind::brute;
  return options;
}

/// Paper, Figure 5: time a step over the simulation, sequential against parallel.
void figure_5(const Settings& settings, int threads, std::vector<Row>& rows) {
  Curves curves = run("5", "tori-on-plane",
                      {{"sequential", papers(ExecutorKind::sequential, 1)},
                       {"threads", papers(ExecutorKind::threads, threads)},
                       {"flowgraph", papers(ExecutorKind::flowgraph, threads)}},
                      settings);
  const std::size_t steps = curves.at_step.size();
  fmt::print("\nFigure 5: {} tori on a plane, {} threads, brute force; ms a step\n", curves.at_step[0][0].n - 1,
             threads);
  fmt::print("{:>12} {:>12} {:>12} {:>12} {:>8}\n", "step", "sequential", "threads", "flowgraph", "ratio");
  const std::size_t every = std::max<std::size_t>(1, steps / 12);
  for (std::size_t step = 0; step < steps; step += every)
    fmt::print("{:>12} {:>12.3f} {:>12.3f} {:>12.3f} {:>7.2f}x\n", step, 1e-6 * curves.median(step, 0),
               1e-6 * curves.median(step, 1), 1e-6 * curves.median(step, 2),
               curves.median(step, 0) / curves.median(step, 2));
  fmt::print("{:>12} {:>12.1f} {:>12.1f} {:>12.1f} {:>7.2f}x\n", "sum", 1e-6 * curves.sum(0), 1e-6 * curves.sum(1),
             1e-6 * curves.sum(2), curves.sum(0) / curves.sum(2));
  append(rows, curves);
}

/// Paper, Figure 7: every strict split and the dynamic one; against them the best strict split of each step.
void figure_7(const Settings& settings, int threads, std::vector<Row>& rows) {
  std::vector<Contestant> contestants;
  for (int broad = 1; broad < threads; ++broad) {
    Contestant strict{fmt::format("strict {}-{}", broad, threads - broad), papers(ExecutorKind::flowgraph, threads)};
    strict.options.split = {broad, threads - broad};
    strict.options.strict_split = true;
    contestants.push_back(std::move(strict));
  }
  const std::size_t splits = contestants.size();
  for (const BalanceRule rule : {BalanceRule::paper, BalanceRule::busy}) {
    Contestant strict{fmt::format("strict dynamic, {} rule", name(rule)), papers(ExecutorKind::flowgraph, threads)};
    strict.options.strict_split = true;
    strict.options.balance = rule;
    contestants.push_back(std::move(strict));
  }
  contestants.push_back({"dynamic, work conserved", papers(ExecutorKind::flowgraph, threads)});
  contestants.push_back({"threads, dynamic", papers(ExecutorKind::threads, threads)});
  contestants.push_back({"barrier", papers(ExecutorKind::barrier, threads)});
  contestants.push_back({"sequential", papers(ExecutorKind::sequential, 1)});

  Curves curves = run("7", "tori-and-cubes", std::move(contestants), settings);
  double oracle = 0;
  for (std::size_t step = 0; step < curves.at_step.size(); ++step) {
    double best = curves.median(step, 0);
    for (std::size_t split = 1; split < splits; ++split) best = std::min(best, curves.median(step, split));
    oracle += best;
  }
  fmt::print("\nFigure 7: 500 tori and 1000 cubes, {} threads, brute force; sum over {} steps, ms\n", threads,
             curves.at_step.size());
  fmt::print("{:<28} {:>10.1f} {:>8}\n", "best strict split a step", 1e-6 * oracle, "1.00");
  for (std::size_t i = 0; i < curves.contestants.size(); ++i)
    fmt::print("{:<28} {:>10.1f} {:>8.2f}\n", curves.contestants[i].name, 1e-6 * curves.sum(i), curves.sum(i) / oracle);
  append(rows, curves);
}

}  // namespace

std::vector<Row> figures_bench(const Settings& settings) {
  if (!settings.scenes.empty()) throw std::invalid_argument("--scene: each figure has its own scene");
  std::vector<int> threads = settings.threads;
  if (threads.empty()) threads = {std::max(2, tbb::info::default_concurrency())};
  std::vector<Row> rows;
  for (const int count : threads) {
    if (count < 2) throw std::invalid_argument(fmt::format("--threads: {}, allowed for figures: from 2", count));
    figure_5(settings, count, rows);
    figure_7(settings, count, rows);
  }
  return rows;
}

}  // namespace tandem::bench
