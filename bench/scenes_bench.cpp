// The paper's four scenes by executor.
#include <fmt/format.h>

#include "benches.h"
#include "contest.h"
#include "progress.h"
#include "tandem/engine/builtin_scenes.h"

namespace tandem::bench {
namespace {

std::vector<Contestant> contestants(int threads) {
  PipelineOptions papers;
  papers.broad_phase = BroadPhaseKind::brute;
  std::vector<Contestant> all = executors(threads, papers);
  Contestant product{"flowgraph, auto", {}};
  product.options.threads = threads;
  all.push_back(std::move(product));
  return all;
}

/// The serial times of the shared steps of a contestant.
struct Serial {
  Samples begin, update, broad, join, share;  // us; share: fraction of all work

  void add(const ExecutionReport& report) {
    if (report.form == StepForm::caller || report.busy_ms <= 0) return;
    begin.add(1e3 * report.serial.begin);
    update.add(1e3 * report.serial.update);
    broad.add(1e3 * report.serial.broad);
    join.add(1e3 * report.serial.join);
    share.add(report.serial.sum() / report.busy_ms);
  }
  void write(nlohmann::json& out) const {
    if (share.size() == 0) return;
    out["serial_us"] = {
        {"begin", begin.median()}, {"update", update.median()}, {"broad", broad.median()}, {"join", join.median()}};
    out["serial_share"] = share.median();
  }
};

}  // namespace

std::vector<Row> scenes_bench(const Settings& settings) {
  std::vector<std::string> scenes = settings.scenes;
  if (scenes.empty())
    for (const BuiltinScene& scene : builtin_scenes().first(4)) scenes.emplace_back(scene.name);
  const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 40 : 200;
  const std::vector<int> thread_counts = settings.threads.empty() ? std::vector<int>{0} : settings.threads;

  std::vector<Row> rows;
  fmt::print("Detection, contacts computed. All but the last use the paper's brute-force broad phase.\n");
  fmt::print("{:<16} {:<16} {:>7} {:>9} {:>9} {:>9} {:>7} {:>9} {:>7}  {}\n", "scene", "executor", "threads", "ms/step",
             "p10", "p90", "ratio", "of copies", "serial", "contact hash, last step");
  for (const std::string& name : scenes)
    for (const int threads : thread_counts) {
      const auto all = contestants(threads);
      std::vector<Row> scene_rows;
      Scene scene = make_builtin_scene(name, settings.bodies);
      for (const Contestant& contestant : all)
        scene_rows.push_back({"scenes", name, contestant.name, 1, scene.bodies(), {}, 0, {{"steps", steps}}});
      std::vector<Serial> serial(all.size());
      Progress progress(name, steps);
      contest(
          std::move(scene), all, {steps, std::max(1, settings.repeat), 10},
          [&](const Turn& turn) {
            Row& row = scene_rows[turn.contestant];
            row.threads = turn.report.execution.threads;
            row.time.add(1e6 * turn.report.execution.detect_ms);
            row.hash = turn.report.contact_hash;
            serial[turn.contestant].add(turn.report.execution);
          },
          [&](int step) { progress.at(step + 1); });
      const double sequential = scene_rows.front().time.median();
      const Row* copies = nullptr;
      for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].copies > 1) copies = &scene_rows[i];
      for (std::size_t i = 0; i < all.size(); ++i)
        if (all[i].copies == 1) serial[i].write(scene_rows[i].more);
      for (Row& row : scene_rows) {
        const double ratio = sequential / row.time.median();
        row.more["ratio_to_sequential"] = ratio;
        row.more["ratio_of_sums"] = scene_rows.front().time.sum() / row.time.sum();
        if (copies != nullptr) row.more["of_copies"] = row.time.sum() / copies->time.sum();
        fmt::print("{:<16} {:<16} {:>7} {:>9.3f} {:>9.3f} {:>9.3f} {:>6.2f}x {:>9} {:>7}  {}\n", name, row.contestant,
                   row.threads, 1e-6 * row.time.median(), 1e-6 * row.time.quantile(0.1), 1e-6 * row.time.quantile(0.9),
                   ratio, copies != nullptr ? fmt::format("{:.2f}", row.time.sum() / copies->time.sum()) : "",
                   row.more.contains("serial_share")
                       ? fmt::format("{:.1f} %", 100 * row.more["serial_share"].get<double>())
                       : "",
                   hex(row.hash));
      }
      rows.insert(rows.end(), scene_rows.begin(), scene_rows.end());
    }
  return rows;
}

}  // namespace tandem::bench
