// Short steps: the speedup by a second thread for scenes, sizes and executors, with workers that sleep between steps or
// stay awake; and many small worlds at once on the threads of a host.
#include <fmt/format.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <chrono>
#include <stdexcept>

#include "benches.h"
#include "contest.h"
#include "progress.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"

namespace tandem::bench {
namespace {

constexpr double awake_us = 2000;  // longer than the pause of a contest's caller between two steps

std::vector<Contestant> short_step_contestants(int threads) {
  std::vector<Contestant> all;
  for (const ExecutorKind kind : {ExecutorKind::sequential, ExecutorKind::barrier, ExecutorKind::flowgraph}) {
    PipelineOptions options;
    options.executor = kind;
    options.threads = threads;
    all.push_back({std::string(name(kind)), options});
  }
  all.push_back(all.back());
  all.back().name = "flowgraph, awake";
  all.back().options.stay_awake = awake_us;
  return all;
}

void scene_rows(std::vector<Row>& rows, const std::string& name, std::size_t bodies, int threads, int steps,
                int repeat) {
  const auto all = short_step_contestants(threads);
  Scene scene = make_builtin_scene(name, bodies);
  std::vector<Row> own;
  std::vector<double> awake_ms(all.size());
  for (const Contestant& contestant : all)
    own.push_back({"short-steps", name, contestant.name, 1, scene.bodies(), {}, 0, {{"steps", steps}}});
  Progress progress(name, steps);
  contest(
      std::move(scene), all, {steps, repeat, 20},
      [&](const Turn& turn) {
        Row& row = own[turn.contestant];
        row.threads = turn.report.execution.threads;
        row.time.add(1e6 * turn.report.execution.detect_ms);
        row.hash = turn.report.contact_hash;
        awake_ms[turn.contestant] += turn.report.execution.awake_ms;
      },
      [&](int step) { progress.at(step + 1); });
  for (std::size_t i = 0; i < own.size(); ++i) {
    Row& row = own[i];
    const double ratio = own.front().time.sum() / row.time.sum();
    row.more["ratio_of_sums"] = ratio;
    row.more["awake_ms_a_step"] = awake_ms[i] / static_cast<double>(row.time.size());
    fmt::print("{:<17} {:>6} {:<17} {:>7} {:>9.3f} {:>9.3f} {:>9.3f} {:>6.2f}x {:>9.3f}  {}\n", name, row.n,
               row.contestant, row.threads, 1e-6 * row.time.median(), 1e-6 * row.time.quantile(0.1),
               1e-6 * row.time.quantile(0.9), ratio, row.more["awake_ms_a_step"].get<double>(), hex(row.hash));
  }
  rows.insert(rows.end(), own.begin(), own.end());
}

/// Falling worlds, a pipeline each: all in turn on one thread, or in a parallel loop of the host.
class Worlds {
 public:
  Worlds(std::size_t count, std::size_t bodies) {
    for (std::size_t i = 0; i < count; ++i) {
      scenes_.push_back(make_builtin_scene("cubes-on-plane", bodies, i + 1));
      pipelines_.emplace_back(
          PipelineOptions{.answer = {.margin = recommended_margin(scenes_[i]), .contact_hash = true}});
    }
    hashes_.resize(count);
    responses_.resize(count);
  }
  void step(tbb::task_arena& arena) {
    arena.execute([this] { tbb::parallel_for(std::size_t{0}, scenes_.size(), [this](std::size_t i) { step(i); }); });
  }
  std::uint64_t hash() const {
    std::uint64_t all = 0;
    for (const std::uint64_t hash : hashes_) all = (all ^ hash) * 0x100000001b3u;
    return all;
  }

 private:
  void step(std::size_t i) {
    hashes_[i] ^= pipelines_[i].step(scenes_[i]).contact_hash;
    responses_[i].step(scenes_[i], pipelines_[i].contacts());
  }
  std::vector<Scene> scenes_;
  std::vector<Pipeline> pipelines_;
  std::vector<Response> responses_;
  std::vector<std::uint64_t> hashes_;
};

void small_worlds(std::vector<Row>& rows, int threads, int steps) {
  constexpr std::size_t count = 64, bodies = 30;
  Worlds alone(count, bodies), together(count, bodies);
  tbb::task_arena one(1), all(threads);
  std::vector<Row> own{{"short-steps", "64 worlds of 30", "one thread", 1, count * bodies, {}, 0},
                       {"short-steps", "64 worlds of 30", "a host's parallel_for", threads, count * bodies, {}, 0}};
  for (int step = 0; step < steps; ++step)
    for (const bool shared : {step % 2 == 0, step % 2 != 0}) {
      const auto begin = std::chrono::steady_clock::now();
      shared ? together.step(all) : alone.step(one);
      const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - begin;
      if (step >= 5) own[shared].time.add(time.count());
    }
  own[0].hash = alone.hash();
  own[1].hash = together.hash();
  if (own[0].hash != own[1].hash) throw std::runtime_error("64 worlds: other contacts on one thread than on several");
  for (Row& row : own) {
    row.more["ratio_of_sums"] = own.front().time.sum() / row.time.sum();
    fmt::print("{:<24} {:<17} {:>7} {:>9.3f} {:>9.3f} {:>9.3f} {:>6.2f}x            {}\n", row.workload, row.contestant,
               row.threads, 1e-6 * row.time.median(), 1e-6 * row.time.quantile(0.1), 1e-6 * row.time.quantile(0.9),
               row.more["ratio_of_sums"].get<double>(), hex(row.hash));
  }
  rows.insert(rows.end(), own.begin(), own.end());
}

}  // namespace

std::vector<Row> short_steps_bench(const Settings& settings) {
  std::vector<std::string> scenes = settings.scenes;
  if (scenes.empty()) scenes = {"cubes-on-plane", "spheres-on-plane", "tori-on-cones", "mixed-grains"};
  std::vector<std::size_t> sizes = settings.sizes;
  if (sizes.empty())
    sizes = settings.quick ? std::vector<std::size_t>{100} : std::vector<std::size_t>{100, 300, 1000, 3000};
  const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 40 : 400;
  const int threads = settings.threads.empty() ? tbb::info::default_concurrency() : settings.threads.front();
  std::vector<Row> rows;
  fmt::print(
      "Detection, contacts computed; ratio: of sums, sequential over it. awake: what workers spun, ms a step.\n");
  fmt::print("{:<17} {:>6} {:<17} {:>7} {:>9} {:>9} {:>9} {:>7} {:>9}  {}\n", "scene", "bodies", "executor", "threads",
             "ms/step", "p10", "p90", "ratio", "awake", "contact hash, last step");
  for (const std::string& name : scenes)
    for (const std::size_t bodies : sizes) scene_rows(rows, name, bodies, threads, steps, std::max(1, settings.repeat));
  small_worlds(rows, threads, steps);
  return rows;
}

}  // namespace tandem::bench
