// Steps and queries that allocate nothing once they are warm, and that survive a refused allocation.
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <vector>

#include "catch.h"
#include "narrowphase/mesh_samples.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"
#include "tandem/engine/scene_queries.h"
#include "tandem/narrowphase/prepare.h"
#include "tandem/narrowphase/shape_makers.h"

namespace {

std::atomic<std::uint64_t> allocations{0};
// Including memory that contacts of large patches of two meshes take.
std::atomic<std::uint64_t> aligned_allocations{0};
std::atomic<std::int64_t> until_refused{-1};  // number of allocations; negative: none is refused

void refuse_in_turn() {
  if (until_refused.load(std::memory_order_relaxed) >= 0 && until_refused.fetch_sub(1) == 0) throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  refuse_in_turn();
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  aligned_allocations.fetch_add(1, std::memory_order_relaxed);
  refuse_in_turn();
  const auto unit = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(unit, (size + unit - 1) / unit * unit)) return memory;
  throw std::bad_alloc();
}
// Not inlined: otherwise g++ reports free as not matching operator new, whose body it does not see.
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

using namespace tandem;

TEST_CASE("pipeline: a step whose load was there before allocates nothing, pairs of meshes and the report included") {
  for (const char* name : {"screws-in-bowl", "tori-on-cones", "cubes-on-plane", "spheres-on-plane"})
    for (const int threads : {1, 2}) {
      CAPTURE(name, threads);
      Scene scene = make_builtin_scene(name, 150);
      PipelineOptions options;
      options.executor = threads == 1 ? ExecutorKind::sequential : ExecutorKind::flowgraph;
      options.threads = threads;
      options.answer.margin = recommended_margin(scene);
      options.sharing.short_step_ms = 0;
      if (threads > 1) {  // in batches whose size does not depend on measured times
        options.batches.pairs = 1;
        options.sharing.form = StepForm::overlapped;
      }
      Pipeline pipeline(options);
      Response response({.threads = 1});
      std::size_t pairs = 0;
      for (int step = 0; step < 60; ++step) {
        pipeline.step(scene);
        pairs = std::max(pairs, pipeline.contacts().pairs.size());
        response.step(scene, pipeline.contacts());
      }
      CHECK(pairs > 20);
      std::uint64_t least = UINT64_MAX;
      for (int step = 0; step < 400 && least != 0; ++step) {
        const std::uint64_t before = allocations.load();
        pipeline.step(scene);
        least = std::min(least, allocations.load() - before);
      }
      CHECK(least == 0);
    }
}

TEST_CASE("queries: a tool that glides over ground, near and touching, allocates nothing after the first round") {
  std::vector<double> heights;
  for (int j = 0; j <= 40; ++j)
    for (int i = 0; i <= 40; ++i) heights.push_back(0.1 * std::sin(0.4 * i) * std::cos(0.3 * j));
  Scene scene;
  BodyOptions ground;
  ground.shape = scene.add_shape(height_field(heights, 41, 41, 0.0987, -1));
  ground.is_static = true;
  scene.add_body(ground);
  NarrowPhaseOptions options;
  // The proof of a depth allocates, and so does a convex shape whose corners are deep in a mesh.
  options.mesh_bounds = false;
  const SceneQueries queries(scene, options);
  const Mesh torus = test::torus(0.3, 0.1, 24, 12);
  for (const Shape& tool : {Shape(torus), Shape(Sphere{0.2})}) {
    CAPTURE(name(tool.kind()));
    std::vector<BodyId> touched;
    std::vector<ContactHit> hits;
    std::vector<Contact> contacts;
    std::size_t in_contact = 0;
    const auto glide = [&] {
      for (int i = 0; i < 100; ++i) {
        const Pose pose{Quat(Eigen::AngleAxisd(0.1 * i, Vec3::UnitX())).toRotationMatrix(),
                        {-1 + 0.02 * i, 0.3, 0.28 + 0.1 * std::sin(0.2 * i)}};
        touched.clear();
        hits.clear();
        contacts.clear();
        queries.collides(tool, pose);
        if (!queries.collides(tool, pose)) queries.nearest(tool, pose, 0.1);
        queries.hits(tool, pose, touched);
        queries.contacts(tool, pose, 0, hits, contacts);
        in_contact += hits.size();
      }
    };
    glide();
    CHECK(in_contact > 5);
    CHECK(in_contact < 95);
    std::uint64_t least = UINT64_MAX;
    for (int again = 0; again < 3 && least != 0; ++again) {
      const std::uint64_t before = allocations.load();
      glide();
      least = std::min(least, allocations.load() - before);
    }
    CHECK(least == 0);
  }
}

TEST_CASE("queries: ten thousand of a tool of ten thousand triangles allocate nothing after the first, in the air") {
  constexpr std::size_t columns = 241;
  const auto height = [](double x, double y) { return 0.03 * std::sin(9 * x) * std::cos(7 * y); };
  std::vector<double> heights;
  for (std::size_t j = 0; j < columns; ++j)
    for (std::size_t i = 0; i < columns; ++i)
      heights.push_back(height(static_cast<double>(i) / 240 - 0.5, static_cast<double>(j) / 240 - 0.5));
  Scene scene;
  BodyOptions ground;
  ground.shape = scene.add_shape(height_field(heights, columns, columns, 1.0 / 240, -0.1));
  ground.is_static = true;
  scene.add_body(ground);
  NarrowPhaseOptions options;
  options.mesh_bounds = false;
  const SceneQueries queries(scene, options);
  const Shape tool(test::torus(0.03, 0.01, 100, 50));
  prepare(tool);
  std::vector<ContactHit> hits;
  std::vector<Contact> contacts;
  hits.reserve(1);
  contacts.reserve(4096);
  std::size_t in_contact = 0;
  const auto ask = [&](const Pose& pose) {
    hits.clear();
    contacts.clear();
    if (!queries.collides(tool, pose)) queries.nearest(tool, pose, 0.001);
    queries.contacts(tool, pose, 0, hits, contacts);
    in_contact += hits.size();
  };
  ask({Mat3::Identity(), {0, 0, 1}});
  REQUIRE(in_contact == 0);
  const std::uint64_t before = allocations.load() + aligned_allocations.load();
  for (int ms = 0; ms < 10'000; ++ms) {
    const double t = 0.001 * ms, x = 0.4 * std::sin(0.5 * t), y = 0.4 * std::sin(0.37 * t + 1);
    const Quat turn = Quat(Eigen::AngleAxisd(0.8 * t, Vec3(1, 2, 3).normalized()));
    ask({turn.toRotationMatrix(), {x, y, height(x, y) + 0.03 + 0.012 * std::sin(2.3 * t)}});
  }
  CHECK(in_contact > 2000);
  CHECK(in_contact < 8000);
  CHECK(allocations.load() + aligned_allocations.load() == before);
}

TEST_CASE("queries: batches of configurations, motions and casts allocate nothing after the first round") {
  Scene scene;
  const Shape torus(test::torus(0.3, 0.1, 24, 12));
  const std::vector<Shape> kinds{Box{{0.4, 0.3, 0.2}}, Cylinder{0.2, 0.4}, Sphere{0.2}, torus};
  for (std::size_t i = 0; i < 60; ++i) {
    const double t = static_cast<double>(i);
    scene.add_body({.shape = scene.add_shape(kinds[i % kinds.size()]),
                    .pose = {Quat(Eigen::AngleAxisd(t, Vec3::UnitZ())).toRotationMatrix(),
                             {2 * std::sin(7 * t), 2 * std::cos(11 * t), 2 * std::sin(13 * t)}},
                    .is_static = true});
  }
  scene.add_body({.shape = scene.add_shape(HalfSpace{{0, 0, 1}, -2.2}), .is_static = true});
  const SceneQueries queries(scene);
  // Proving how deep a link is in a mesh allocates.
  QueryFilter no_mesh;
  no_mesh.admits = [&](BodyId body) { return scene.shape_of(body.index()).is_convex(); };
  BatchOptions convex_bodies;
  convex_bodies.filter = no_mesh;
  const std::vector<Shape> links{Capsule{0.1, 0.5}, Box{{0.2, 0.2, 0.5}}, Capsule{0.05, 0.4}};
  PairTable self(3, 3, true);
  constexpr std::size_t a_motion = 20, motions = 30;
  std::vector<Pose> poses;
  for (std::size_t i = 0; i < a_motion * motions; ++i)
    for (std::size_t link = 0; link < links.size(); ++link) {
      const double t = 0.02 * static_cast<double>(i) + 2.1 * static_cast<double>(link);
      poses.push_back({Quat(Eigen::AngleAxisd(t, Vec3::UnitX())).toRotationMatrix(),
                       {1.5 * std::sin(3 * t), 1.5 * std::cos(2 * t), std::sin(t)}});
    }
  std::vector<Verdict> verdicts(a_motion * motions), of_motions(motions);
  std::vector<FirstHit> hits(a_motion * motions), hits_of_motions(motions);
  std::vector<double> clearances(a_motion * motions);
  BatchOptions in_motions;
  in_motions.configurations_a_motion = a_motion;
  std::size_t touched = 0;
  const auto round = [&] {
    queries.check(links, poses, self, verdicts);
    queries.check(links, poses, self, of_motions, in_motions);
    queries.first_hits(links, poses, self, hits);
    queries.first_hits(links, poses, self, hits_of_motions, in_motions);
    queries.clearance(links, poses, self, clearances, 10, convex_bodies);
    for (std::size_t i = 0; i + links.size() < poses.size(); i += 50 * links.size())
      touched += queries.cast(links[0], {poses[i], poses[i + links.size()]}, no_mesh).has_value();
  };
  round();
  const auto hit = static_cast<std::size_t>(std::count(verdicts.begin(), verdicts.end(), Verdict::hit));
  CHECK(hit > 50);
  CHECK(hit < verdicts.size() - 50);
  CHECK(touched > 0);
  std::uint64_t least = UINT64_MAX;
  for (int again = 0; again < 3 && least != 0; ++again) {
    const std::uint64_t before = allocations.load() + aligned_allocations.load();
    round();
    least = std::min(least, allocations.load() + aligned_allocations.load() - before);
  }
  CHECK(least == 0);
}

TEST_CASE("queries: after an update that ran out of memory they refuse, and the next one makes up for it") {
  const std::vector<Shape> asked{Sphere{0.5}, Box{{0.3, 0.2, 1}}, Capsule{0.2, 2}};
  enum class Change { moves, comes, goes };
  for (const Change change : {Change::moves, Change::comes, Change::goes}) {
    std::size_t refused = 0;
    // Refuses some of the allocations that prepare a mesh, and all of the others.
    const bool ready = change == Change::comes;
    for (std::int64_t turn = 0;; turn += ready ? 1 : 1 + turn / 8) {
      CAPTURE(static_cast<int>(change), turn);
      Scene scene;
      std::vector<BodyId> bodies;
      for (int i = 0; i < 20; ++i)
        bodies.push_back(
            scene.add_body({.shape = scene.add_shape(Box{{0.4, 0.3, 0.2}}), .pose = Pose::at(i % 5, i / 5, 0)}));
      SceneQueries queries(scene);
      const Shape torus(test::torus(0.3, 0.1, 24, 12));
      if (ready) prepare(torus);
      const BodyOptions ring{.shape = scene.add_shape(torus), .pose = Pose::at(2, 2, 0.5)};
      if (change == Change::moves) scene.set_pose(bodies[7], Pose::at(0, 0, 0.7));
      if (change == Change::goes) scene.remove_body(bodies[7]);
      if (change != Change::moves) scene.add_body(ring);
      bool threw = false;
      until_refused = turn;
      try {
        tbb::task_arena(1).execute([&] { queries.update(scene); });
      } catch (const std::bad_alloc&) {
        threw = true;
      }
      until_refused = -1;
      if (!threw) break;
      ++refused;
      std::vector<Hit> near;
      CHECK_THROWS_AS(queries.collides(asked[0], Pose{}), std::logic_error);
      CHECK_THROWS_AS(queries.nearest(bodies[3]), std::logic_error);
      CHECK_THROWS_AS(queries.within(asked[0], Pose::at(100, 0, 0), 1, near), std::logic_error);
      CHECK_THROWS_AS(queries.cast(asked[0], {Pose{}, Pose::at(100, 0, 0)}), std::logic_error);
      std::vector<Verdict> verdict(1);
      CHECK_THROWS_AS(queries.check({asked.data(), 1}, std::vector<Pose>(1), PairTable(), verdict), std::logic_error);
      queries.update(scene);
      const SceneQueries others(scene);
      for (const Shape& shape : asked)
        for (int i = 0; i < 10; ++i) {
          const auto found = queries.nearest(shape, Pose::at(0.5 * i, 0.4 * i, 1)),
                     expected = others.nearest(shape, Pose::at(0.5 * i, 0.4 * i, 1));
          REQUIRE(found);
          CHECK(found->body == expected->body);
          CHECK(found->answer.signed_distance == expected->answer.signed_distance);
        }
    }
    CHECK(refused > 3);
  }
}
