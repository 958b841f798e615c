// The whole detection step on recorded poses, beside FCL's and Bullet's collision worlds.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

#include "answer_hash.h"
#include "benches.h"
#include "option_text.h"
#include "peers/recorded_scene.h"
#include "peers/scene_detector.h"
#include "progress.h"

namespace tandem::bench {
namespace {

using Clock = std::chrono::steady_clock;

/// The results of a contestant over all timed steps.
struct StepTally {
  Samples time;
  Samples stretches, pile;  // medians of stretches; of stretches in the last quarter of the steps
  std::uint64_t pairs = 0, contacts = 0;
  double kept_pairs = 0;
  std::uint64_t missed = 0, extra = 0;  // pairs, compared with the first contestant's
  std::uint64_t hash = hash_start;      // FNV-1a over all steps
};

std::vector<TouchingPair> sorted(std::vector<TouchingPair> pairs) {
  std::sort(pairs.begin(), pairs.end(),
            [](const TouchingPair& x, const TouchingPair& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
  return pairs;
}

std::size_t missing(const std::vector<TouchingPair>& from, const std::vector<TouchingPair>& of) {
  std::size_t count = 0;
  for (auto i = from.begin(), j = of.begin(); j != of.end(); ++j) {
    while (i != from.end() && (i->a != j->a ? i->a < j->a : i->b < j->b)) ++i;
    count += i == from.end() || i->a != j->a || i->b != j->b;
  }
  return count;
}

SceneDetectors contestants(const Scene& scene, const std::vector<int>& threads) {
  SceneDetectors all = tandem_detectors(threads);
  for (auto& detector : fcl_detectors(scene)) all.push_back(std::move(detector));
#ifdef TANDEM_HAS_BULLET
  for (auto& detector : bullet_detectors(scene)) all.push_back(std::move(detector));
#endif
  return all;
}

std::vector<StepTally> play(RecordedScene& recorded, const SceneDetectors& detectors) {
  const std::size_t n = detectors.size();
  std::vector<StepTally> tallies(n);
  // A contestant detects a whole stretch, as in a simulation, where each step finds in the caches what the step before
  // left. The contestant that ran before it differs from stretch to stretch.
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(1);
  Progress progress("detect", recorded.stretches.size());
  for (const Stretch& stretch : recorded.stretches) {
    const std::size_t steps = stretch.poses.size();
    std::vector<std::vector<std::vector<TouchingPair>>> found(n);  // [contestant][step]
    std::shuffle(order.begin(), order.end(), random);
    for (const std::size_t who : order) {
      StepTally& tally = tallies[who];
      Samples own;
      for (std::size_t k = 0; k < steps; ++k) {
        for (std::uint32_t i = 0; i < recorded.scene.indices(); ++i)
          if (recorded.scene.is_static()[i] == 0)
            recorded.scene.move(i, stretch.poses[k][i], Vec3::Zero(), Vec3::Zero());
        const auto begin = Clock::now();
        detectors[who]->detect(recorded.scene);
        const double ns = std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
        found[who].push_back(detectors[who]->found());
        if (k < untimed_steps) continue;
        tally.time.add(ns);
        tally.kept_pairs += detectors[who]->kept_pairs();
        own.add(ns);
      }
      tally.stretches.add(own.median());
      if (4 * (stretch.first_step + steps) > 3 * recorded.steps) tally.pile.add(own.median());
    }
    for (std::size_t k = untimed_steps; k < steps; ++k) {
      const std::vector<TouchingPair> ours = sorted(std::move(found[0][k]));
      for (std::size_t i = 0; i < n; ++i) {
        const std::vector<TouchingPair> theirs = i == 0 ? ours : sorted(std::move(found[i][k]));
        StepTally& tally = tallies[i];
        tally.pairs += theirs.size();
        for (const TouchingPair& pair : theirs) {
          tally.contacts += pair.contacts;
          add(tally.hash, std::uint64_t{pair.a} << 32 | pair.b);
          add(tally.hash, pair.contacts);
          add(tally.hash, std::bit_cast<std::uint64_t>(pair.depth));
        }
        tally.missed += missing(theirs, ours);
        tally.extra += missing(ours, theirs);
      }
    }
    progress.at(&stretch - recorded.stretches.data() + 1);
  }
  return tallies;
}

RecordedScene poses_of(const std::string& name, const Settings& settings) {
  const std::size_t steps = settings.steps != 0 ? static_cast<std::size_t>(settings.steps) : settings.quick ? 200 : 400;
  for (const PeersScene& scene : peers_scenes())
    if (scene.name == name) return simulate(scene, settings.bodies, steps, settings.quick ? 16 : scene.timed);
  return read_recorded(name, settings.steps != 0 ? steps : SIZE_MAX, settings.quick ? 16 : 64);
}

/// For each stretch, the fastest other contestant's time over that of each of ours.
std::vector<Samples> ratios_to_peers(const std::vector<StepTally>& tallies, std::size_t ours) {
  const StepTally& fastest =
      *std::min_element(tallies.begin() + static_cast<std::ptrdiff_t>(ours), tallies.end(),
                        [](const StepTally& x, const StepTally& y) { return x.time.median() < y.time.median(); });
  // The speed of cores changes within seconds: only times of the same stretch are compared.
  std::vector<Samples> ratios(ours);
  for (std::size_t i = 0; i < ours; ++i)
    for (std::size_t k = 0; k < fastest.stretches.size(); ++k)
      ratios[i].add(fastest.stretches[k] / tallies[i].stretches[k]);
  return ratios;
}

Row row_of(const RecordedScene& recorded, const SceneDetector& detector, StepTally& tally, const Samples* ratio) {
  fmt::print("{:<19} {:<18} {:>7} {:>6} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9} {:>9} {:>7} {:>7} {:>22}  {}\n",
             recorded.name, detector.name(), detector.threads(), tally.time.size(), 1e-6 * tally.time.median(),
             1e-6 * tally.time.quantile(0.1), 1e-6 * tally.time.quantile(0.9), 1e-6 * tally.pile.median(), tally.pairs,
             tally.contacts, tally.missed, tally.extra,
             ratio != nullptr ? fmt::format("{:.2f}x ({:.2f} to {:.2f})", ratio->median(), ratio->quantile(0.1),
                                            ratio->quantile(0.9))
                              : "",
             hex(tally.hash));
  Row row{"peers",
          recorded.name,
          detector.name(),
          detector.threads(),
          recorded.scene.bodies(),
          std::move(tally.time),
          tally.hash,
          {{"steps", recorded.steps},
           {"mean_ns", 0},
           {"pile_ns", tally.pile.median()},
           {"pairs", tally.pairs},
           {"contacts", tally.contacts},
           {"kept_pairs", tally.kept_pairs},
           {"pairs_missed", tally.missed},
           {"pairs_extra", tally.extra}}};
  row.more["mean_ns"] = row.time.mean();
  if (ratio != nullptr) {
    row.more["ratio_to_fastest_peer"] = ratio->median();
    row.more["ratio_p10"] = ratio->quantile(0.1);
    row.more["ratio_p90"] = ratio->quantile(0.9);
  }
  return row;
}

}  // namespace

std::vector<std::string> peers_scene_names() {
  std::vector<std::string> names;
  for (const PeersScene& scene : peers_scenes()) names.emplace_back(scene.name);
  return names;
}

std::vector<Row> peers_bench(const Settings& settings) {
  std::vector<std::string> names = settings.scenes;
  if (names.empty()) names = peers_scene_names();
  std::vector<int> threads = settings.threads.empty() ? std::vector<int>{1, 2} : settings.threads;

  std::vector<Row> rows;
  fmt::print(
      "The whole detection step, contacts computed, on recorded poses. ms a step; pairs and contacts of all timed "
      "steps;\npile: of stretches in the last quarter; missed, extra: pairs beside tandem's; ratio: the fastest other\n"
      "contestant's time of a stretch over tandem's of the same, median, p10 and p90.\n"
      "{:<19} {:<18} {:>7} {:>6} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>7} {:>7} {:>22}  {}\n",
      "scene", "contestant", "threads", "steps", "median", "p10", "p90", "pile", "pairs", "contacts", "missed", "extra",
      "ratio", "hash");
  for (const std::string& name : names) {
    RecordedScene recorded = poses_of(name, settings);
    const SceneDetectors detectors = contestants(recorded.scene, threads);
    std::vector<StepTally> tallies = play(recorded, detectors);
    const std::size_t ours = 2 * threads.size();
    for (std::size_t i = 1; i < ours; ++i)
      if (i != threads.size() && tallies[i].hash != tallies[i - 1].hash)
        throw std::runtime_error(
            fmt::format("{}: other contacts on {} threads than on {}", recorded.name, threads[i], threads[0]));
    const std::vector<Samples> ratios = ratios_to_peers(tallies, ours);
    for (std::size_t i = 0; i < tallies.size(); ++i)
      rows.push_back(row_of(recorded, *detectors[i], tallies[i], i < ours ? &ratios[i] : nullptr));
  }
  return rows;
}

}  // namespace tandem::bench
