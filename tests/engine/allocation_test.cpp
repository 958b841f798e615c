#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "catch.h"
#include "narrowphase/mesh_samples.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"
#include "tandem/engine/scene_queries.h"
#include "tandem/narrowphase/shape_makers.h"

namespace {

std::atomic<std::uint64_t> allocations{0};

}  // namespace

void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

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
      if (threads > 1) {  // in batches whose size does not go with measured times
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
  // The proof of a depth takes memory as it goes, and so does a convex shape with corners deep in a mesh.
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
