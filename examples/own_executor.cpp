// A user's executor: oneTBB's parallel loops with a static division, each thread an equal share of the tiles, whose
// pairs it narrows itself.
#include <oneapi/tbb/enumerable_thread_specific.h>
#include <oneapi/tbb/parallel_for.h>

#include <cstdio>
#include <memory>
#include <vector>

#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/flowgraph/narrowing_sink.h"
#include "tandem/flowgraph/tile_work.h"

namespace {

template <class Body>
void equal_parts(std::size_t n, const Body& body) {
  tbb::parallel_for(std::size_t{0}, n, body, tbb::static_partitioner());
}

class EqualParts final : public tandem::Executor {
 public:
  void run(tandem::StepWork& work, tandem::ContactList& contacts, tandem::ExecutionReport& report, std::stop_token stop,
           tandem::Timeline*) override {
    const auto begin = std::chrono::steady_clock::now();
    const std::size_t last = work.begin() - 1;
    for (std::size_t stage = 0; stage < last; ++stage)
      equal_parts(work.blocks(stage), [&](std::size_t block) { work.run(stage, block); });
    // A thread's sink narrows whenever a batch is full, and keeps the answers.
    tbb::enumerable_thread_specific<tandem::NarrowingSink> sinks([&] { return tandem::NarrowingSink(work); });
    equal_parts(work.blocks(last), [&](std::size_t tile) {
      if (!stop.stop_requested()) work.emit(tile, sinks.local());
    });
    std::vector<tandem::AnswerChunk*> answers;
    for (tandem::NarrowingSink& sink : sinks) {
      sink.flush();
      report.candidate_pairs += sink.candidates();
      answers.push_back(&sink.answers());
    }
    if (stop.stop_requested()) {  // a stopped step has no answer
      report.issues |= bit(tandem::StepIssue::ended_early);
      answers.clear();
    }
    joiner_.join(answers, work.bodies(), contacts);
    report.threads = tbb::this_task_arena::max_concurrency();
    report.detect_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
  }

 private:
  tandem::Joiner joiner_;  // keeps its memory from step to step
};

}  // namespace

int main() {
  const tandem::Scene scene = tandem::make_builtin_scene("tori-and-cubes", 300);
  tandem::PipelineOptions options;
  options.answer = {.margin = 1, .contact_hash = true};
  const std::uint64_t expected = tandem::Pipeline(options).step(scene).contact_hash;
  options.own_executor = [](const tandem::ExecutorOptions&) { return std::make_unique<EqualParts>(); };
  tandem::Pipeline pipeline(options);
  std::uint64_t pairs = 0;
  for (int step = 0; step < 3; ++step) {
    const tandem::StepReport report = pipeline.step(scene);
    if (report.contact_hash != expected) std::puts("WRONG: other contacts");
    pairs = report.execution.candidate_pairs;
  }
  std::printf("a scene: %zu pairs, the same contacts\n", static_cast<std::size_t>(pairs));

  // A synthetic load: tiles of 5 us, each with 20 pairs of 0.3 us; the possible speedup, and this executor's.
  tandem::TileWork load({.tiles = 100, .pairs_a_tile = 20, .tile_ns = 5000, .pair_ns = 300});
  tandem::ContactList list, usual;
  tandem::ExecutionReport own, sequential;
  EqualParts equal_parts;
  const auto one_thread = tandem::make_executor({.kind = tandem::ExecutorKind::sequential});
  for (int step = 0; step < 3; ++step) {  // later steps reuse the memory of the first
    own = sequential = {};
    equal_parts.run(load, list, own, {}, nullptr);
    one_thread->run(load, usual, sequential, {}, nullptr);
  }
  if (hash(list) != hash(usual)) std::puts("WRONG: other answers");
  std::printf("a made-up load: %.2f of the time of one thread\n", own.detect_ms / sequential.detect_ms);
}
