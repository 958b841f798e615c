#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "catch.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"

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
