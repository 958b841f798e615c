#include <algorithm>
#include <functional>
#include <random>

#include "catch.h"
#include "tandem/engine/pipeline.h"

using namespace tandem;

namespace {

std::vector<Pair> pairs_in_order(const Pipeline& pipeline) {
  std::vector<Pair> pairs;
  for (const auto& pair : pipeline.contacts().pairs) pairs.push_back({pair.a, pair.b});
  return pairs;
}

}  // namespace

TEST_CASE("many bodies: one order of all pairs for each broad phase, executor and number of threads") {
  // Enough bodies for several blocks of every stage and for sorts in parts; three steps, so that lists are made and
  // used.
  constexpr std::size_t n = 33'000;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(0, 60);
  Scene scene;
  const auto ball = scene.add_shape(Sphere{0.5});
  std::vector<Pose> poses;
  std::vector<BodyId> bodies;
  for (std::size_t i = 0; i < n; ++i) {
    poses.push_back(Pose::at(place(random), place(random), place(random)));
    bodies.push_back(scene.add_body({.shape = ball, .pose = poses.back()}));
  }
  std::vector<Pipeline> pipelines;
  pipelines.emplace_back(PipelineOptions{.executor = ExecutorKind::sequential,
                                         .threads = 1,
                                         .broad_phase = BroadPhaseKind::brute,
                                         .answer = {.request = Request::collide}});
  for (const BroadPhaseKind kind :
       {BroadPhaseKind::sweep, BroadPhaseKind::grid, BroadPhaseKind::bvh, BroadPhaseKind::automatic})
    for (const auto& [executor, threads] : {std::pair{ExecutorKind::sequential, 1},
                                            {ExecutorKind::barrier, 4},
                                            {ExecutorKind::fused, 3},
                                            {ExecutorKind::threads, 4},
                                            {ExecutorKind::flowgraph, 4},
                                            {ExecutorKind::flowgraph, 2}})
      pipelines.emplace_back(PipelineOptions{
          .executor = executor, .threads = threads, .broad_phase = kind, .answer = {.request = Request::collide}});
  for (int step = 0; step < 3; ++step) {
    for (std::size_t i = 0; i < n; ++i) {
      poses[i].translation[0] += 0.01;
      poses[i].translation[static_cast<int>(i % 3)] += 0.02;
      scene.set_pose(bodies[i], poses[i]);
    }
    std::vector<Pair> expected;
    for (Pipeline& pipeline : pipelines) {
      pipeline.step(scene);
      const std::vector<Pair> found = pairs_in_order(pipeline);
      CAPTURE(step, &pipeline - pipelines.data());
      if (expected.empty()) {
        expected = found;
        REQUIRE(expected.size() > 1000);
        CHECK(std::adjacent_find(expected.begin(), expected.end(), std::greater_equal<>()) == expected.end());
      }
      CHECK((found == expected));
    }
  }
}
