// The gap between the bounds on the depth of two solids deep in each other: those of the distance query, and those of
// penetration_depth by the number of boxes of translations that it may examine.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "benches.h"
#include "depths/families.h"
#include "progress.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/penetration.h"

namespace tandem::bench {
namespace {

constexpr double wanted = 0.05, allowed = 0.2;  // gaps relative to the upper bound
constexpr double rounding_of_depths = 1e-9;

// The relative gaps and times of one budget.
struct Spread {
  Row row;
  std::vector<double> gaps;
  std::size_t boxes = 0;

  void add(double lower, double upper, std::size_t looked_at, double ns) {
    gaps.push_back(upper > 0 ? (upper - lower) / upper : 0);
    row.time.add(ns);
    boxes += looked_at;
    row.hash = std::rotl(row.hash, 5) ^ std::bit_cast<std::uint64_t>(lower) ^ std::bit_cast<std::uint64_t>(upper);
  }

  void finish(const std::string& family, const std::string& contestant) {
    std::sort(gaps.begin(), gaps.end());
    const auto within = [&](double gap) {
      return std::upper_bound(gaps.begin(), gaps.end(), gap + rounding_of_depths) - gaps.begin();
    };
    const auto quantile = [&](double q) {
      return gaps[static_cast<std::size_t>(q * static_cast<double>(gaps.size() - 1))];
    };
    row.bench = "depths";
    row.workload = family;
    row.contestant = contestant;
    row.n = gaps.size();
    row.more = {{"gap_p50", quantile(0.5)},
                {"gap_p90", quantile(0.9)},
                {"gap_max", gaps.back()},
                {"within_5_percent", within(wanted)},
                {"within_20_percent", within(allowed)},
                {"mean_boxes", static_cast<double>(boxes) / static_cast<double>(gaps.size())}};
    fmt::print("{:7}{:16}{:6}{:9.3f}{:9.3f}{:9.3f}{:8}{:8}{:9.0f}{:10.2f}{:10.2f}  {}\n", family, contestant, row.n,
               quantile(0.5), quantile(0.9), gaps.back(), within(wanted), within(allowed),
               row.more["mean_boxes"].get<double>(), row.time.median() / 1e6, row.time.quantile(0.9) / 1e6,
               hex(row.hash));
  }
};

template <class Work>
double timed(Work&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
}

std::vector<Row> measure(const DepthFamily& family, std::size_t pairs, const std::vector<std::size_t>& budgets) {
  std::vector<Spread> spreads(1 + budgets.size());
  reference::Random random(7);
  const NarrowPhase narrow;
  Progress progress(family.name, pairs);
  for (std::size_t done = 0; done < pairs;) {
    const DeepPair pair = family.make(random);
    PairAnswer plain;
    const double ns = timed([&] { plain = narrow.solve(pair.a, pair.pose_a, pair.b, pair.pose_b, Request::distance); });
    if (!plain.collide) continue;
    spreads[0].add(-plain.signed_distance - plain.error_bound, -plain.signed_distance, 0, ns);
    for (std::size_t k = 0; k < budgets.size(); ++k) {
      DepthBounds bounds;
      const double taken = timed(
          [&] { bounds = penetration_depth(pair.a, pair.pose_a, pair.b, pair.pose_b, {.most_boxes = budgets[k]}); });
      const Pose moved{pair.pose_b.rotation, pair.pose_b.translation + bounds.translation};
      if (narrow.solve(pair.a, pair.pose_a, pair.b, moved, Request::collide).collide)
        throw std::runtime_error("a translation does not separate");
      spreads[1 + k].add(bounds.lower, bounds.upper, bounds.boxes, taken);
    }
    progress.at(++done);
  }
  spreads[0].finish(family.name, "distance");
  for (std::size_t k = 0; k < budgets.size(); ++k)
    spreads[1 + k].finish(family.name, fmt::format("{} boxes", budgets[k]));
  std::vector<Row> rows;
  for (Spread& spread : spreads) rows.push_back(std::move(spread.row));
  return rows;
}

}  // namespace

std::vector<Row> depths_bench(const Settings& settings) {
  const std::size_t pairs = settings.poses != 0 ? settings.poses : settings.quick ? 5 : 100;
  const std::vector<std::size_t> budgets =
      !settings.sizes.empty() ? settings.sizes : std::vector<std::size_t>{200, 1000, 5000, 20'000, 80'000};
  fmt::print(
      "Two solids of some hundred to a thousand triangles, turned anyhow, deep in each other. The gap is what the "
      "bounds on "
      "their\ndepth are apart, of the upper one: median, 90 % and most, and how many are within 5 and 20 %. One "
      "thread, ms "
      "a pair.\n\n");
  fmt::print("{:7}{:16}{:>6}{:>9}{:>9}{:>9}{:>8}{:>8}{:>9}{:>10}{:>10}  hash\n", "", "", "pairs", "gap", "90 %", "most",
             "5 %", "20 %", "boxes", "ms", "90 %");
  std::vector<Row> rows;
  for (const DepthFamily& family : depth_families()) {
    if (!settings.kinds.empty() &&
        std::find(settings.kinds.begin(), settings.kinds.end(), family.name) == settings.kinds.end())
      continue;
    for (Row& row : measure(family, pairs, budgets)) rows.push_back(std::move(row));
  }
  if (rows.empty()) throw std::invalid_argument("--kind: no family of that name; bowls, rings, gears, tori, blobs");
  return rows;
}

}  // namespace tandem::bench
