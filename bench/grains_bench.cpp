// A bed of spheres with a radius each, as codes of the discrete element method have them: time of a step beside a plain
// cell list (depths alone, or the same list as tandem to the last bit) and Bullet, and memory. LAMMPS' granular package
// is no contestant: it reports pairs only within a whole time step of its own, forces included.
#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <random>
#include <stdexcept>

#include "answer_hash.h"
#include "benches.h"
#include "clocks.h"
#include "grains/cell_list.h"
#include "peers/scene_detector.h"
#include "progress.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"

namespace tandem::bench {
namespace {

/// A time in ns: for a single thread its processor time, which other processes disturb less than wall time.
double now_ns(bool alone) { return alone ? cpu_ns() : wall_ns(); }

constexpr std::size_t untimed = 2, timed = 6;  // steps of a stretch

/// Bytes in use of the heap.
double heap() {
  const struct mallinfo2 now = mallinfo2();
  return static_cast<double>(now.uordblks + now.hblkhd);
}

/// Memory by data structure, as the scene and the pipeline report it, in bytes a body.
nlohmann::json by_part(const SceneMemory& scene, const PipelineMemory& pipeline, double bodies) {
  const auto each = [bodies](std::size_t bytes) { return static_cast<double>(bytes) / bodies; };
  return {{"scene_bodies", each(scene.bodies)},       {"scene_shapes", each(scene.shapes)},
          {"pipeline_bodies", each(pipeline.bodies)}, {"broad_phase", each(pipeline.broad_phase)},
          {"executor", each(pipeline.executor)},      {"contacts", each(pipeline.contacts)}};
}

constexpr int memory_steps = 12;  // the list of candidates is made in the third step

/// Runs steps that move all bodies a little, but for static ones.
void fall(Scene& scene, Pipeline& pipeline) {
  for (int step = 0; step < memory_steps; ++step) {
    const auto poses = scene.poses();
    for (std::uint32_t i = 0; i < scene.indices(); ++i) {
      if (scene.is_static()[i] != 0) continue;
      Pose pose = poses[i];
      pose.translation.z() -= 1e-3 * scene.shape_of(i).radius();
      scene.move(i, pose, Vec3::Zero(), Vec3::Zero());
    }
    pipeline.step(scene);
  }
}

/// Memory in bytes a body of a bed whose grains touch, by Scene::memory and Pipeline::memory, on one thread, without
/// the list of contacts.
nlohmann::json memory_of_bed(Scene scene, std::size_t bodies) {
  Pipeline pipeline({.executor = ExecutorKind::sequential});
  fall(scene, pipeline);
  const PipelineMemory held = pipeline.memory();
  const auto n = static_cast<double>(bodies);
  return {{"contacts_a_body", static_cast<double>(pipeline.contacts().contacts.size()) / n},
          {"bytes_a_body", static_cast<double>(scene.memory().total() + held.total() - held.contacts) / n},
          {"by_part", by_part(scene.memory(), held, n)}};
}

/// Memory in bytes a body, before any grains touch: the scene; a pipeline after some steps that move all bodies,
/// without its list of contacts, on one thread and on two; the list, bytes a contact.
nlohmann::json memory_of(std::size_t bodies) {
  const double empty = heap();
  Scene scene = make_builtin_scene("grains", bodies);
  const auto n = static_cast<double>(bodies);
  nlohmann::json out{{"scene_bytes_a_body", (heap() - empty) / n},
                     {"bytes_a_contact", sizeof(PairResult) + sizeof(Contact)}};
  for (const int threads : {1, 2}) {
    const double before = heap();
    Pipeline pipeline(
        {.executor = threads == 1 ? ExecutorKind::sequential : ExecutorKind::flowgraph, .threads = threads});
    fall(scene, pipeline);
    const ContactList& list = pipeline.contacts();
    const double answers =
        static_cast<double>(list.pairs.capacity() * sizeof(PairResult) + list.contacts.capacity() * sizeof(Contact));
    out[threads == 1 ? "pipeline_bytes_a_body" : "pipeline_bytes_a_body_two_threads"] = (heap() - before - answers) / n;
    if (threads == 1) out["bytes_a_body_by_part"] = by_part(scene.memory(), pipeline.memory(), n);
  }
  return out;
}

struct Tally {
  Samples time, stretches;
  std::uint64_t pairs = 0, hash = hash_start;
  std::vector<std::uint64_t> lists;  // the hash of the list of each step

  void add(std::uint64_t word) { bench::add(hash, word); }
  void add(std::vector<TouchingPair> found) {
    std::sort(found.begin(), found.end(),
              [](const TouchingPair& x, const TouchingPair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
    pairs += found.size();
    for (const TouchingPair& pair : found) {
      add(std::uint64_t{pair.a} << 32 | pair.b);
      add(std::bit_cast<std::uint64_t>(pair.depth + 0.0));
    }
  }
};

std::string spread(const Samples& ratios) {
  return fmt::format("{:.2f}x ({:.2f} to {:.2f})", ratios.median(), ratios.quantile(0.1), ratios.quantile(0.9));
}

SceneDetectors grain_contestants(const Scene& scene, const std::vector<int>& threads) {
  SceneDetectors all;
  for (auto& detector : tandem_detectors(threads))
    if (detector->name() == "tandem") all.push_back(std::move(detector));
  for (auto& detector : cell_list_detectors(scene)) all.push_back(std::move(detector));
#ifdef TANDEM_HAS_BULLET
  for (auto& detector : bullet_detectors(scene)) all.push_back(std::move(detector));
#endif
  return all;
}

using Poses = std::vector<Pose>;

/// Detects all poses in turn, and times all but the first ones.
void play(Scene& scene, const std::vector<Poses>& stretch, SceneDetector& who, Tally& tally) {
  Samples own;
  for (std::size_t k = 0; k < stretch.size(); ++k) {
    for (std::uint32_t i = 0; i < scene.indices(); ++i)
      if (scene.is_static()[i] == 0) scene.move(i, stretch[k][i], Vec3::Zero(), Vec3::Zero());
    const double begin = now_ns(who.threads() == 1);
    who.detect(scene);
    const double ns = now_ns(who.threads() == 1) - begin;
    if (k < untimed) continue;
    tally.time.add(ns);
    own.add(ns);
    tally.add(who.found());
    tally.lists.push_back(who.list_hash());
  }
  tally.stretches.add(own.median());
}

/// A bed that has come to rest but for some grains: what all detectors find in the following steps.
std::vector<Tally> contest(Scene& scene, const SceneDetectors& all, int settling, int stretches,
                           nlohmann::json& memory) {
  Scene ahead = scene;
  Pipeline pipeline({.answer = {.margin = recommended_margin(ahead)}});
  Response response;
  Progress progress("grains", settling + stretches);
  const auto go_on = [&] {
    pipeline.step(ahead);
    response.step(ahead, pipeline.contacts());
  };
  for (int step = 0; step < settling; ++step, progress.at(step)) go_on();
  memory["bed"] = memory_of_bed(ahead, ahead.bodies());
  std::vector<Tally> tallies(all.size());
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(1);
  for (int k = 0; k < stretches; ++k) {
    std::vector<Poses> stretch;
    for (std::size_t step = 0; step < untimed + timed; ++step, go_on())
      stretch.emplace_back(ahead.poses().begin(), ahead.poses().end());
    std::shuffle(order.begin(), order.end(), random);
    for (const std::size_t who : order) play(scene, stretch, *all[who], tallies[who]);
    progress.at(settling + k + 1);
  }
  return tallies;
}

void print_memory(const nlohmann::json& memory) {
  fmt::print("bytes a body: scene {:.0f}, pipeline {:.0f} ({:.0f} of two threads) and {} a contact\n",
             memory["scene_bytes_a_body"].get<double>(), memory["pipeline_bytes_a_body"].get<double>(),
             memory["pipeline_bytes_a_body_two_threads"].get<double>(), memory["bytes_a_contact"].get<int>());
  const auto print_parts = [](const nlohmann::json& parts) {
    for (const auto& [part, bytes] : parts.items()) fmt::print(" {} {:.0f}", part, bytes.get<double>());
    fmt::print("\n");
  };
  fmt::print("as they tell it:");
  print_parts(memory["bytes_a_body_by_part"]);
  const nlohmann::json& bed = memory["bed"];
  fmt::print("in the bed, {:.2f} contacts a body: {:.0f} without the list;", bed["contacts_a_body"].get<double>(),
             bed["bytes_a_body"].get<double>());
  print_parts(bed["by_part"]);
}

}  // namespace

std::vector<Row> grains_bench(const Settings& settings) {
  std::vector<std::size_t> sizes = settings.sizes;
  if (sizes.empty()) sizes = settings.quick ? std::vector<std::size_t>{2000} : std::vector<std::size_t>{20000, 100000};
  const std::vector<int> threads = settings.threads.empty() ? std::vector<int>{1, 2} : settings.threads;
  const int settling = settings.steps != 0 ? settings.steps : 100;
  const int stretches = settings.repeat != 0 ? settings.repeat : settings.quick ? 2 : 8;
  std::vector<Row> rows;
  fmt::print(
      "Spheres in a box, each with a radius of its own; ms a step, contacts computed; on one thread of the processor.\n"
      "ahead: time of a stretch of the cell list that makes the same list, and of the one that tells depths alone, "
      "over\n"
      "that of the same poses; median, p10 and p90.\n"
      "{:<9} {:<18} {:>7} {:>9} {:>9} {:>9} {:>24} {:>24} {:>10}  {}\n",
      "grains", "contestant", "threads", "median", "p10", "p90", "ahead, same list", "ahead, depths", "pairs", "hash");
  for (const std::size_t size : sizes) {
    nlohmann::json memory = memory_of(size);
    Scene scene = make_builtin_scene("grains", size);
    const SceneDetectors all = grain_contestants(scene, threads);
    std::vector<Tally> tallies = contest(scene, all, settling, stretches, memory);
    const Tally &depths = tallies[threads.size()], &list = tallies[threads.size() + 1];
    for (std::size_t i = 0; i < threads.size(); ++i)
      if (tallies[i].hash != depths.hash || tallies[i].hash != list.hash || tallies[i].lists != list.lists)
        throw std::runtime_error(
            fmt::format("{} grains: {} on {} threads found other pairs, depths or contacts than the cell list", size,
                        all[i]->name(), all[i]->threads()));
    for (std::size_t i = 0; i < all.size(); ++i) {
      Tally& tally = tallies[i];
      Samples ahead, ahead_of_depths;
      for (std::size_t k = 0; k < tally.stretches.size(); ++k) {
        ahead.add(list.stretches[k] / tally.stretches[k]);
        ahead_of_depths.add(depths.stretches[k] / tally.stretches[k]);
      }
      fmt::print("{:<9} {:<18} {:>7} {:>9.3f} {:>9.3f} {:>9.3f} {:>24} {:>24} {:>10}  {}\n", size, all[i]->name(),
                 all[i]->threads(), 1e-6 * tally.time.median(), 1e-6 * tally.time.quantile(0.1),
                 1e-6 * tally.time.quantile(0.9), spread(ahead), spread(ahead_of_depths), tally.pairs, hex(tally.hash));
      Row row{"grains",
              "grains",
              all[i]->name(),
              all[i]->threads(),
              size,
              tally.time,
              tally.hash,
              {{"pairs", tally.pairs},
               {"ratio_to_cell_list", ahead.median()},
               {"ratio_p10", ahead.quantile(0.1)},
               {"ratio_p90", ahead.quantile(0.9)},
               {"ratio_to_depths", ahead_of_depths.median()}}};
      if (i == 0) row.more.update(memory);
      rows.push_back(std::move(row));
    }
    print_memory(memory);
  }
  return rows;
}

}  // namespace tandem::bench
