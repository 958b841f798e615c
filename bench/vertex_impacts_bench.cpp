// Continuous collision detection of vertices on straight lines: the time of an answer on queries of simulations and on
// hard ones, each answer compared with the exact one.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "benches.h"
#include "clocks.h"
#include "impact_queries.h"
#include "progress.h"

namespace tandem::bench {
namespace {

using reference::ExactImpact;
using reference::ImpactFamily;
using reference::ImpactQuery;

constexpr std::size_t timed_together = 50;
/// Motions below this length, relative to the coordinates, may be lost to rounding.
constexpr double rounding = 1e-13;

struct Verdicts {
  std::size_t hits = 0, missed = 0, late = 0, in_vain = 0, beyond = 0, early = 0;

  void add(const ImpactQuery& query, const VertexImpact& answer, double tolerance) {
    const ExactImpact exact(query);
    if (exact.hit()) {
      ++hits;
      missed += !answer.hit;
      late += exact.hit_before(answer.t);
      early += !exact.hit_before(std::nextafter(answer.t + tolerance, 2));
    } else if (answer.hit) {
      ++in_vain;
      double reach = 0;
      for (std::size_t i = 1; i < 4; ++i)
        reach = std::max({reach, (query.from[i] - query.from[0]).norm(), (query.to[i] - query.to[0]).norm()});
      beyond += answer.gap > tolerance * reference::longest_motion(query) + 10 * rounding * reach;
    }
  }
};

Row measure(const ImpactFamily& family, std::size_t queries, std::uint64_t seed) {
  reference::Random random(seed);
  const ImpactOptions options;
  Row row;
  Verdicts verdicts;
  std::vector<ImpactQuery> some(timed_together);
  std::vector<VertexImpact> answers(timed_together);
  Progress progress(family.name, queries);
  for (std::size_t done = 0; done < queries; done += timed_together) {
    for (ImpactQuery& query : some) query = family.make(random);
    const double begin = cpu_ns();
    for (std::size_t i = 0; i < timed_together; ++i) answers[i] = reference::solve(some[i], options);
    row.time.add((cpu_ns() - begin) / static_cast<double>(timed_together));
    for (std::size_t i = 0; i < timed_together; ++i) {
      row.hash = std::rotl(row.hash, 5) ^ std::bit_cast<std::uint64_t>(answers[i].t) ^
                 std::bit_cast<std::uint64_t>(answers[i].gap);
      verdicts.add(some[i], answers[i], options.tolerance);
    }
    progress.at(done);
  }
  row.bench = "vertex-impacts";
  row.workload = family.name;
  row.contestant = "tandem";
  row.n = row.time.size() * timed_together;
  row.more = {{"mean_ns", row.time.mean()},
              {"hits", verdicts.hits},
              {"missed", verdicts.missed},
              {"late", verdicts.late},
              {"in_vain", verdicts.in_vain},
              {"beyond_tolerance", verdicts.beyond},
              {"earlier_than_tolerance", verdicts.early}};
  return row;
}

}  // namespace

std::vector<Row> vertex_impacts_bench(const Settings& settings) {
  const std::size_t queries = settings.poses != 0 ? settings.poses : settings.quick ? 1000 : 40'000;
  fmt::print(
      "Impacts of a point and a triangle or of two edges, vertices on straight lines, tolerance 1e-6, one thread. "
      "Times are "
      "ns of an answer,\nmedians and means of {} in a row; the rest are answers held against exact ones: hits, those "
      "missed, told too late, told in vain,\nof these beyond the tolerance, and hits told earlier than by 1e-6.\n\n",
      timed_together);
  fmt::print("{:19}{:>9}{:>8}{:>8}{:>9}{:>8}{:>6}{:>9}{:>8}{:>9}  hash\n", "", "queries", "median", "mean", "hits",
             "missed", "late", "in vain", "beyond", "early");
  std::vector<Row> rows;
  for (const ImpactFamily& family : reference::impact_families()) {
    rows.push_back(measure(family, queries, 100 + rows.size()));
    const Row& row = rows.back();
    const auto count = [&](const char* key) { return row.more[key].get<std::size_t>(); };
    fmt::print("{:19}{:9}{:8.0f}{:8.0f}{:9}{:8}{:6}{:9}{:8}{:9}  {}\n", row.workload, row.n, row.time.median(),
               row.time.mean(), count("hits"), count("missed"), count("late"), count("in_vain"),
               count("beyond_tolerance"), count("earlier_than_tolerance"), hex(row.hash));
    if (count("missed") + count("late") != 0) throw std::runtime_error("an impact was missed or told too late");
  }
  return rows;
}

}  // namespace tandem::bench
