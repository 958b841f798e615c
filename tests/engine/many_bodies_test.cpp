// Steps of many bodies, and the memory they take.
#include <malloc.h>

#include <algorithm>
#include <functional>
#include <random>

#include "catch.h"
#include "tandem/engine/builtin_scenes.h"
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
  // Enough bodies for several blocks of every stage and for parallel sorts; three steps, so that lists are made and
  // used.
  constexpr std::size_t n = 33'000;
  std::mt19937 random(2);
  std::uniform_real_distribution<double> place(0, 60);
  Scene scene;
  const auto ball = scene.add_shape(Sphere{0.5});
  std::vector<Pose> poses;
  std::vector<BodyId> bodies;
  for (std::size_t i = 0; i < n; ++i) {
    poses.push_back({Mat3::Identity(), {place(random), place(random), place(random)}});
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

TEST_CASE("many bodies: what 100,000 spheres with a shape each take of memory, by part, and in all") {
  constexpr std::size_t n = 100'000;
  const auto heap = [] { return static_cast<double>(mallinfo2().uordblks + mallinfo2().hblkhd); };
  const double empty = heap();
  Scene scene = make_builtin_scene("grains", n);
  const double with_scene = heap();
  const auto a_body = [&](auto bytes) { return static_cast<double>(bytes) / n; };
  const SceneMemory in_scene = scene.memory();
  CHECK(a_body(in_scene.bodies) < 180);
  CHECK(a_body(in_scene.shapes) < 85);
  CHECK(a_body(in_scene.shape_names) < 1);
  const auto fall = [&](Pipeline& pipeline) {
    for (int step = 0; step < 4; ++step) {
      for (std::uint32_t i = 0; i < scene.indices(); ++i)
        if (scene.is_static()[i] == 0) {
          Pose pose = scene.poses()[i];
          pose.translation.z() -= 1e-3 * scene.shape_of(i).radius();
          scene.move(i, pose, Vec3::Zero(), Vec3::Zero());
        }
      pipeline.step(scene);
    }
    return pipeline.memory();
  };
  {
    Pipeline pipeline({.executor = ExecutorKind::sequential});
    const PipelineMemory in_pipeline = fall(pipeline);
    REQUIRE(pipeline.contacts().pairs.empty());
    CHECK(a_body(in_scene.total() + in_pipeline.total()) < 500);
  }
  for (std::uint32_t i = 0; i < scene.indices(); ++i) {
    if (scene.is_static()[i] != 0) continue;
    Pose pose = scene.poses()[i];
    pose.translation *= 0.75;  // so that they touch
    scene.set_pose(scene.id(i), pose);
  }
  Pipeline pipeline({.executor = ExecutorKind::sequential});
  const PipelineMemory in_pipeline = fall(pipeline);
  CHECK(a_body(in_pipeline.bodies) < 65);
  CHECK(a_body(in_pipeline.broad_phase) < 195);
  CHECK(a_body(in_pipeline.executor) < 95);
  CHECK(in_pipeline.kept_answers == 0);
  REQUIRE(pipeline.contacts().pairs.size() > n);
  CHECK(in_pipeline.contacts >= pipeline.contacts().pairs.size() * sizeof(PairResult));
  CHECK(a_body(in_scene.total() + in_pipeline.total() - in_pipeline.contacts) < 600);
  if (empty == 0) return;  // malloc is not glibc's, but a sanitizer's, for example
  // The reported memory is the allocated memory, except for malloc's overhead and partly used large pages.
  const double scene_held = (with_scene - empty) / n, pipeline_held = (heap() - with_scene) / n;
  CHECK(std::abs(a_body(in_scene.total()) - scene_held) < 0.1 * scene_held);
  CHECK(std::abs(a_body(in_pipeline.total()) - pipeline_held) < 0.2 * pipeline_held);
}
