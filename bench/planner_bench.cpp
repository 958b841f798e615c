// The planner bench: verdicts, motions and clearances of robot arms, compared with FCL and Bullet.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <numeric>
#include <random>

#include "answer_hash.h"
#include "benches.h"
#include "planner/planner.h"
#include "progress.h"

namespace tandem::bench {
namespace {

using Clock = std::chrono::steady_clock;

enum class PlannerQuestion { check, motions, clearance };

const char* name(PlannerQuestion question) {
  return question == PlannerQuestion::check     ? "configurations"
         : question == PlannerQuestion::motions ? "motions"
                                                : "clearance";
}

/// The answers of a contestant, and the time of each round per query.
struct AnswerTally {
  Samples time;
  std::vector<double> answers;
};

/// One round of a slice of the questions.
void play(Planner& planner, PlannerQuestion question, std::span<const Pose> poses, std::size_t questions,
          AnswerTally& tally) {
  std::vector<std::uint8_t> hits(questions);
  std::vector<double> distances(questions);
  const auto begin = Clock::now();
  if (question == PlannerQuestion::check)
    planner.check(poses, hits);
  else if (question == PlannerQuestion::motions)
    planner.check_motions(poses, hits);
  else
    planner.clearance(poses, distances);
  const double ns = std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
  tally.time.add(ns / static_cast<double>(questions));
  if (question == PlannerQuestion::clearance)
    tally.answers.insert(tally.answers.end(), distances.begin(), distances.end());
  else
    tally.answers.insert(tally.answers.end(), hits.begin(), hits.end());
}

/// Answers that are not the first contestant's: verdicts, or distances off by more than a micrometre.
std::size_t others(const AnswerTally& ours, const AnswerTally& theirs) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < ours.answers.size(); ++i) count += std::abs(ours.answers[i] - theirs.answers[i]) > 1e-6;
  return count;
}

std::vector<Row> ask(const PlannerWorld& world, PlannerQuestion question, std::size_t rounds,
                     const std::vector<int>& threads) {
  Planners planners;
  for (const int n : threads) planners.push_back(tandem_planner(world, n));
  planners.push_back(fcl_planner(world));
  const std::size_t peer = planners.size() - 1;
#ifdef TANDEM_HAS_BULLET
  if (question != PlannerQuestion::clearance) planners.push_back(bullet_planner(world));
#endif
  const std::span<const Pose> all = question == PlannerQuestion::motions ? world.motions : world.random;
  const std::size_t per_question =
      world.links.size() * (question == PlannerQuestion::motions ? PlannerWorld::a_motion : 1);
  // A clearance takes as long as dozens of verdicts.
  const std::size_t a_round = all.size() / per_question / rounds / (question == PlannerQuestion::clearance ? 20 : 1);
  std::vector<AnswerTally> tallies(planners.size());
  std::vector<std::size_t> order(planners.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::mt19937 random(1);
  for (std::size_t round = 0; round < rounds; ++round) {
    std::shuffle(order.begin(), order.end(), random);
    const auto poses = all.subspan(round * a_round * per_question, a_round * per_question);
    for (const std::size_t who : order) play(*planners[who], question, poses, a_round, tallies[who]);
  }
  std::vector<Row> rows;
  for (std::size_t i = 0; i < planners.size(); ++i) {
    AnswerTally& tally = tallies[i];
    const double hits = question == PlannerQuestion::clearance
                            ? static_cast<double>(std::count(tally.answers.begin(), tally.answers.end(), 0.0))
                            : std::accumulate(tally.answers.begin(), tally.answers.end(), 0.0);
    std::uint64_t hash = hash_start;
    for (const double answer : tally.answers) add(hash, std::bit_cast<std::uint64_t>(answer));
    Samples ratio;
    for (std::size_t k = 0; k < rounds; ++k) ratio.add(tallies[peer].time[k] / tally.time[k]);
    fmt::print(
        "{:<36} {:<15} {:<8} {:>2} {:>11.3f} {:>9.3f} {:>9.3f} {:>6.1f} % {:>7} {:>7.2f}x ({:.2f} to {:.2f})  {}\n",
        world.name, name(question), planners[i]->name(), planners[i]->threads(), 1e-3 * tally.time.median(),
        1e-3 * tally.time.quantile(0.1), 1e-3 * tally.time.quantile(0.9),
        100 * hits / static_cast<double>(tally.answers.size()), others(tallies[0], tally), ratio.median(),
        ratio.quantile(0.1), ratio.quantile(0.9), hex(hash));
    Row row{"planner",
            world.name + ", " + name(question),
            planners[i]->name(),
            planners[i]->threads(),
            world.obstacles.bodies(),
            tally.time,
            hash,
            {}};
    row.more = {{"hits", hits},
                {"questions", tally.answers.size()},
                {"others", others(tallies[0], tally)},
                {"ratio_to_fcl", ratio.median()},
                {"ratio_p10", ratio.quantile(0.1)},
                {"ratio_p90", ratio.quantile(0.9)}};
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

std::vector<Row> planner_bench(const Settings& settings) {
  // A round's tenth of them takes a thread 2 ms: another one wakes within 0.07.
  const std::size_t configurations = settings.poses != 0 ? settings.poses : settings.quick ? 1280 : 96000;
  const std::vector<int> threads = settings.threads.empty() ? std::vector<int>{1, 2} : settings.threads;
  fmt::print(
      "A planner's questions, by arms and obstacles: us a question (median, p10, p90 of rounds), hits, answers that "
      "are not\n"
      "tandem's on one thread, times faster than FCL (DynamicAABBTreeCollisionManager) in the same round.\n"
      "FCL goes through a motion of {} configurations from the start.\n",
      PlannerWorld::a_motion);
  std::vector<Row> rows;
  for (const int arms : {1, 2})
    for (const LinkKind kind : {LinkKind::capsules, LinkKind::hulls, LinkKind::meshes})
      for (const int obstacles : {30, 300}) {
        if (settings.quick && (arms == 2) != (obstacles == 300)) continue;
        const PlannerWorld world = planner_world(kind, arms, obstacles, configurations);
        for (const PlannerQuestion question :
             {PlannerQuestion::check, PlannerQuestion::motions, PlannerQuestion::clearance})
          for (Row& row : ask(world, question, 10, threads)) rows.push_back(std::move(row));
      }
  return rows;
}

}  // namespace tandem::bench
