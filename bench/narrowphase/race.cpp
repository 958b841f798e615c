// Times contestants in turn.
#include "race.h"
#include "clocks.h"

#include <algorithm>
#include <numeric>
#include <random>

namespace tandem::bench {
namespace {

double run(const std::function<void()>& pass, int times) {
  const double start = cpu_ns();
  for (int i = 0; i < times; ++i) pass();
  return cpu_ns() - start;
}

}  // namespace

std::vector<Samples> race(const std::vector<Runner>& runners, int rounds) {
  constexpr double sample_ns = 1e5, budget_ns = 2e8;
  struct Plan {
    int passes, rounds;
  };
  std::vector<Plan> plans;
  for (const Runner& runner : runners) {
    double once = run(runner.pass, 1);
    if (once < sample_ns) once = std::max(run(runner.pass, 1), 1.0);  // the first pass fills the caches
    const int passes = std::max(1, static_cast<int>(sample_ns / once));
    const auto affordable = static_cast<int>(std::min(budget_ns / (once * (passes + 1)), 1e6));
    plans.push_back({passes, runner.queries() == 0 ? 0 : std::clamp(affordable, 1, rounds)});
  }
  std::vector<Samples> out(runners.size());
  // A contestant that follows one with the same code finds the branch predictor trained: so the order changes.
  std::vector<std::size_t> order(runners.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(1);
  for (int round = 0; round < rounds; ++round) {
    std::shuffle(order.begin(), order.end(), random);
    for (const std::size_t who : order) {
      const auto& [passes, most] = plans[who];
      if (round >= most) continue;
      const auto& [pass, queries] = runners[who];
      pass();  // fills the caches with its own data first, so that the contestant before does not matter
      const double time = run(pass, passes);
      if (queries() > 0) out[who].add(time / (static_cast<double>(passes) * static_cast<double>(queries())));
    }
  }
  return out;
}

}  // namespace tandem::bench
