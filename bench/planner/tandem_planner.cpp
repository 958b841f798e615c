// tandem as a contestant of the planner bench: SceneQueries.
#include <fmt/format.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>

#include "planner/planner.h"
#include "tandem/engine/scene_queries.h"

namespace tandem::bench {
namespace {

class TandemPlanner final : public Planner {
 public:
  TandemPlanner(const PlannerWorld& world, int threads)
      : world_(world), queries_(world.obstacles), arena_(threads), threads_(threads) {}

  std::string name() const override { return "tandem"; }
  int threads() const override { return threads_; }

  void check(std::span<const Pose> poses, std::span<std::uint8_t> hits) override { run(poses, hits, 1); }
  void check_motions(std::span<const Pose> poses, std::span<std::uint8_t> hits) override {
    run(poses, hits, PlannerWorld::a_motion);
  }
  void clearance(std::span<const Pose> poses, std::span<double> distances) override {
    arena_.execute([&] { queries_.clearance(world_.links, poses, world_.self, distances); });
    for (double& d : distances) d = std::max(d, 0.0);
  }

 private:
  void run(std::span<const Pose> poses, std::span<std::uint8_t> hits, std::size_t a_motion) {
    verdicts_.resize(hits.size());
    BatchOptions options;
    options.configurations_a_motion = a_motion;
    arena_.execute([&] { queries_.check(world_.links, poses, world_.self, verdicts_, options); });
    std::transform(verdicts_.begin(), verdicts_.end(), hits.begin(), [](Verdict v) { return v != Verdict::free; });
  }

  const PlannerWorld& world_;
  SceneQueries queries_;
  tbb::task_arena arena_;
  int threads_;
  std::vector<Verdict> verdicts_;
};

}  // namespace

std::unique_ptr<Planner> tandem_planner(const PlannerWorld& world, int threads) {
  return std::make_unique<TandemPlanner>(world, threads);
}

}  // namespace tandem::bench
