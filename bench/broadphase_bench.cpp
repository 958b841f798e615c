// Broad phases beside each other: overlapping boxes of typical worlds and of those made to break methods.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <thread>

#include "benches.h"
#include "broadphase/contestant.h"
#include "broadphase/moving_boxes.h"
#include "clocks.h"
#include "option_text.h"
#include "progress.h"

namespace tandem::bench {
namespace {

struct Entrant {
  std::unique_ptr<BoxContestant> contestant;
  bool ours = false;
  Row row{};
  Samples cpu{};                               // processor time of the calling thread
  Samples first_batch{}, first_batch_share{};  // time until the first batch, and its fraction of the step
  double first_step = 0, longest = 0;          // ns
  std::size_t reported = 0, pairs = 0;
  bool agrees = true;
  bool exact = true;       // reports exactly the wanted pairs
  bool reference = false;  // runs on one thread to give the speedup of the same on several; makes no row

  /// The time compared, ns: on one thread its processor time, which other processes disturb less.
  double median() const { return row.threads == 1 ? cpu.median() : row.time.median(); }
  double mean() const { return row.threads == 1 ? cpu.mean() : row.time.mean(); }
};

/// The speedup that this machine gives at best: arithmetic in registers, on one thread and on all of them.
class Ceiling {
 public:
  void measure(int threads) {
    alone_.add(together(1));
    together_.add(together(threads));
    threads_ = threads;
  }
  /// The speedup over one thread, by medians; 0 without a measurement.
  double ratio() const { return alone_.size() == 0 ? 0 : threads_ * alone_.median() / together_.median(); }

 private:
  static double together(int threads) {
    std::atomic<double> result{0};
    const auto work = [&] {
      double x = 1;
      for (int i = 0; i < 1'000'000; ++i) x = x * 0.999999 + 1e-9;
      result.store(x, std::memory_order_relaxed);
    };
    const Clock::time_point begin = Clock::now();
    std::vector<std::thread> others;
    for (int t = 1; t < threads; ++t) others.emplace_back(work);
    work();
    for (std::thread& other : others) other.join();
    return std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
  }
  Samples alone_, together_;
  int threads_ = 1;
};

std::vector<Entrant> entrants(int threads) {
  std::vector<Entrant> all;
  for (const BroadPhaseKind kind : {BroadPhaseKind::automatic, BroadPhaseKind::grid, BroadPhaseKind::bvh,
                                    BroadPhaseKind::sweep, BroadPhaseKind::brute})
    all.push_back({tandem_contestant(kind, threads), true});
  if (threads == 1) all.push_back({fcl_contestant()});
#ifdef TANDEM_HAS_EMBREE
  all.push_back({embree_contestant(true, threads)});
  all.push_back({embree_contestant(false, threads)});
#endif
#ifdef TANDEM_HAS_BULLET
  if (threads == 1) all.push_back({bullet_contestant()});
#endif
#ifdef TANDEM_HAS_CGAL
  if (threads == 1) all.push_back({cgal_contestant()});
#endif
  return all;
}

/// Reduces pairs to the permitted ones that truly overlap, each once.
void make_exact(const BoxArray& boxes, const PairFilter& filter, std::vector<Pair>& pairs) {
  std::erase_if(pairs, [&](const Pair p) { return !filter.allows(p.a, p.b) || !overlap(boxes[p.a], boxes[p.b]); });
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

/// A hash independent of the order; a pair that occurs twice changes it. The mixer is SplitMix64's (Steele et al.
/// 2014).
std::uint64_t hash_of(const std::vector<Pair>& pairs) {
  std::uint64_t sum = pairs.size();
  for (const Pair p : pairs) {
    std::uint64_t z = (std::uint64_t{p.a} << 32 | p.b) + 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    sum += z ^ (z >> 31);
  }
  return sum;
}

int default_steps(std::size_t n, bool quick) { return quick ? 4 : n <= 20'000 ? 40 : n <= 200'000 ? 16 : 6; }

/// Runs all steps of a world at one size; in every step each entrant in turn, the order rotates.
Ceiling race(MovingBoxes& world, int steps, int threads, std::vector<Entrant>& all, Progress& progress) {
  const std::size_t n = all.size();
  Ceiling ceiling;
  PairList list;
  const PairFilter filter{{}, {}, world.is_static()};
  const bool all_wanted = world.is_static().empty();
  for (Entrant& entrant : all)
    entrant.exact = entrant.contestant->exact() && (entrant.contestant->filter(filter) || all_wanted);
  for (int step = 0; step < steps; ++step) {
    if (step != 0) world.move();
    if (threads > 1) ceiling.measure(threads);
    std::vector<std::optional<std::uint64_t>> hashes(n);
    for (std::size_t turn = 0; turn < n; ++turn) {
      const std::size_t who = (turn + static_cast<std::size_t>(step)) % n;
      Entrant& entrant = all[who];
      list.clear();
      if (step != 0) entrant.contestant->changes(world.changes());
      const Clock::time_point begin = Clock::now();
      const double cpu_begin = cpu_ns();
      entrant.contestant->step(world.boxes(), list);
      const double cpu = cpu_ns() - cpu_begin;
      const double ns = std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
      if (step == 0) {
        entrant.first_step = ns;
      } else {
        entrant.row.time.add(ns);
        entrant.cpu.add(cpu);
        entrant.longest = std::max(entrant.longest, ns);
      }
      if (list.first_batch() != Clock::time_point{}) {
        const double until = std::chrono::duration<double, std::nano>(list.first_batch() - begin).count();
        entrant.first_batch.add(until);
        entrant.first_batch_share.add(until / ns);
      }
      entrant.reported = list.pairs().size();
      if (!entrant.exact && step != 0 && step + 1 != steps) continue;  // filtering takes longer than the race
      if (!entrant.exact) make_exact(world.boxes(), filter, list.pairs());
      hashes[who] = hash_of(list.pairs());
      entrant.row.hash = *hashes[who];
      entrant.pairs = list.pairs().size();
    }
    for (std::size_t who = 0; who < n; ++who) {
      if (!hashes[who] || *hashes[who] == *hashes[0]) continue;
      all[who].agrees = false;
      if (all[who].ours)
        throw std::runtime_error(fmt::format("step {}: {} and {} found different pairs", step,
                                             all[0].contestant->name(), all[who].contestant->name()));
    }
    progress.at(step + 1);
  }
  return ceiling;
}

void finish(std::string_view workload, std::size_t boxes, int steps, const Ceiling& ceiling,
            std::vector<Entrant>& all) {
  for (Entrant& entrant : all) {
    Row& row = entrant.row;
    row.bench = "broadphase";
    row.workload = workload;
    row.contestant = entrant.contestant->name();
    row.threads = entrant.contestant->threads();
    row.n = boxes;
    row.more = {{"steps", steps},
                {"pairs", entrant.pairs},
                {"reported", entrant.reported},
                {"first_step_ns", entrant.first_step},
                {"max_ns", entrant.longest},
                {"cpu_median_ns", entrant.cpu.median()},
                {"cpu_p10_ns", entrant.cpu.quantile(0.1)},
                {"cpu_mean_ns", entrant.cpu.mean()},
                {"mean_ns", entrant.row.time.mean()},
                {"agrees", entrant.agrees}};
    if (entrant.contestant->memory() != 0)
      row.more["bytes_a_body"] = static_cast<double>(entrant.contestant->memory()) / static_cast<double>(boxes);
    if (entrant.first_batch.size() != 0) {
      row.more["first_batch_ns"] = entrant.first_batch.median();
      row.more["first_batch_share"] = entrant.first_batch_share.median();
      row.more["first_batch_share_p90"] = entrant.first_batch_share.quantile(0.9);
    }
    if (const std::string note = entrant.contestant->note(); !note.empty()) row.more["note"] = note;
  }
  // Ratios among contestants with the same number of threads, by medians and by means.
  for (Entrant& entrant : all) {
    const auto rate = [&](double (Entrant::*score)() const, const std::string& by) {
      double best = std::numeric_limits<double>::infinity(), peer = best;
      for (const Entrant& other : all) {
        if (other.reference) {
          if (other.row.contestant == entrant.row.contestant && &other != &entrant)
            entrant.row.more["speedup" + by] = (other.*score)() / (entrant.*score)();
          continue;
        }
        double& least = other.ours ? best : peer;
        if (other.ours || other.agrees) least = std::min(least, (other.*score)());
        if (other.row.contestant == "FCL tree")
          entrant.row.more["fcl" + by + "_ratio"] = (other.*score)() / (entrant.*score)();
      }
      if (std::isfinite(peer)) entrant.row.more["peer" + by + "_ratio"] = peer / (entrant.*score)();
      if (std::isfinite(best)) entrant.row.more["best" + by + "_ratio"] = (entrant.*score)() / best;
    };
    rate(&Entrant::median, "");
    rate(&Entrant::mean, "_mean");
    if (entrant.row.threads > 1) entrant.row.more["ceiling"] = ceiling.ratio();
  }
}

void print(const Entrant& entrant) {
  const Row& row = entrant.row;
  const auto ms = [](double ns) { return 1e-6 * ns; };
  const auto number = [&](const char* key) { return row.more.contains(key) ? row.more[key].get<double>() : 0.0; };
  fmt::print("{:<10} {:>8} {:<15} {:>2}", row.workload, row.n, row.contestant, row.threads);
  for (const double ns : {row.time.median(), row.time.quantile(0.1), row.time.quantile(0.9), entrant.median(),
                          entrant.mean(), entrant.longest, entrant.first_step, number("first_batch_ns")})
    fmt::print(" {:>9.3f}", ms(ns));
  for (const char* key : {"best_ratio", "best_mean_ratio", "peer_ratio", "peer_mean_ratio", "fcl_ratio",
                          "fcl_mean_ratio", "speedup", "speedup_mean", "ceiling"})
    row.more.contains(key) ? fmt::print(" {:>6.2f}", number(key)) : fmt::print(" {:>6}", "-");
  fmt::print(" {:>6.0f} {:>9}{} {}{}\n", number("bytes_a_body"), entrant.reported, entrant.exact ? " " : "*",
             hex(row.hash), entrant.agrees ? "" : " wrong pairs");
}

std::vector<int> thread_counts(const Settings& settings) {
  if (!settings.threads.empty()) return settings.threads;
  return settings.quick ? std::vector<int>{1} : std::vector<int>{1, 2};
}

void check_contestants(const Settings& settings) {
  std::set<std::string> known;
  for (const int threads : thread_counts(settings))
    for (const Entrant& entrant : entrants(threads)) known.insert(entrant.contestant->name());
  for (const std::string& name : settings.contestants)
    if (!known.contains(name)) refuse_option("--contestant", name, fmt::format("{}", fmt::join(known, ", ")));
}

void print_heads() {
  fmt::print(
      "ms a step on boxes that are given anew: update, report every overlapping pair. time, mean: median and mean "
      "that\n"
      "are compared, on one thread processor time; longest: of all steps but the first; batch: until the first {} "
      "pairs.\n"
      "best: times our fastest; peer, FCL: how many times faster than the fastest peer, than FCL's tree, on as many\n"
      "threads; t1: than itself on one thread in the same race; each by medians and by means (~). most: what threads "
      "gain\n"
      "here on arithmetic alone. bytes: held a body between steps. A * reports too many pairs: filtered outside the "
      "time.\n\n",
      PairList::batch);
  fmt::print("{:<10} {:>8} {:<15} {:>2}", "boxes", "n", "contestant", "t");
  for (const char* head : {"median", "p10", "p90", "time", "mean", "longest", "first", "batch"})
    fmt::print(" {:>9}", head);
  for (const char* head : {"best", "best~", "peer", "peer~", "FCL", "FCL~", "t1", "t1~", "most", "bytes"})
    fmt::print(" {:>6}", head);
  fmt::print(" {:>9}  {}\n", "reported", "hash");
}

bool is_wanted(std::span<const std::string> names, std::string_view name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<std::size_t> sizes_of(const BoxWorkload& workload, const Settings& settings) {
  std::vector<std::size_t> sizes = settings.sizes;
  if (sizes.empty() && settings.quick) sizes = {300};
  if (sizes.empty() && workload.breaking) sizes = {10'000, 100'000};
  if (sizes.empty()) sizes = {1'000, 10'000, 100'000, 1'000'000};
  for (std::size_t& n : sizes)
    if (workload.most != 0) n = std::min(n, workload.most);
  sizes.erase(std::unique(sizes.begin(), sizes.end()), sizes.end());
  return sizes;
}

/// The time at the size before, ns a box, by contestant and threads.
using BoxTimes = std::map<std::pair<std::string, int>, double>;

/// The contestants asked for; on several threads also ours on one, for the speedup.
std::vector<Entrant> racing(std::size_t n, int threads, const Settings& settings, const BoxTimes& before) {
  // A contestant that would take longer than this, by its time at the size before, is left out.
  constexpr double longest_step = 1.5e9;
  std::vector<Entrant> all = entrants(threads);
  std::erase_if(all, [&](const Entrant& entrant) {
    const std::string name = entrant.contestant->name();
    if (!is_wanted(settings.contestants, name) || (name == "tandem brute" && n > 10'000)) return true;
    const auto known = before.find({name, threads});
    return known != before.end() && known->second * 2 * static_cast<double>(n) > longest_step;
  });
  if (threads == 1) return all;
  for (const BroadPhaseKind kind : {BroadPhaseKind::automatic, BroadPhaseKind::grid}) {
    Entrant one{tandem_contestant(kind, 1), true};
    one.reference = true;
    if (std::any_of(all.begin(), all.end(),
                    [&](const Entrant& entrant) { return entrant.contestant->name() == one.contestant->name(); }))
      all.push_back(std::move(one));
  }
  return all;
}

void run(const BoxWorkload& workload, std::size_t n, int threads, const Settings& settings, BoxTimes& times,
         std::vector<Row>& rows) {
  std::vector<Entrant> all = racing(n, threads, settings, times);
  const int steps = settings.steps != 0 ? settings.steps + 1 : default_steps(n, settings.quick);
  const auto world = make_moving_boxes(workload.name, n);
  Progress progress(workload.name, steps);
  const Ceiling ceiling = race(*world, steps, threads, all, progress);
  finish(workload.name, n, steps, ceiling, all);
  for (const Entrant& entrant : all) {
    if (entrant.reference) continue;
    print(entrant);
    double& worst = times[{entrant.contestant->name(), threads}];
    worst = std::max(entrant.row.time.median(), 0.5 * entrant.first_step) / static_cast<double>(n);
    rows.push_back(entrant.row);
  }
}

}  // namespace

std::vector<std::string> broadphase_scenes() {
  std::vector<std::string> names;
  for (const BoxWorkload& workload : box_workloads()) names.emplace_back(workload.name);
  return names;
}

std::vector<Row> broadphase_bench(const Settings& settings) {
  check_contestants(settings);
  print_heads();
  std::vector<Row> rows;
  for (const BoxWorkload& workload : box_workloads()) {
    if (!is_wanted(settings.scenes, workload.name)) continue;
    BoxTimes times;
    for (const std::size_t n : sizes_of(workload, settings)) {
      // One thread count after the other, since Embree's devices share their threads.
      for (const int threads : thread_counts(settings)) run(workload, n, threads, settings, times, rows);
      fmt::print("\n");
      std::fflush(stdout);
    }
  }
  return rows;
}

}  // namespace tandem::bench
