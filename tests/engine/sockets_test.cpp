// User-defined parts of a pipeline: broad phase, executor, cost model.
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/parallel_for.h>

#include <atomic>

#include "catch.h"
#include "message_of.h"
#include "settled_scene.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"
#include "tandem/flowgraph/narrowing_sink.h"

using namespace tandem;

namespace {

/// All pairs by a double loop, a row a block; and pairs that a wrong method may put.
class Plain final : public BroadPhase {
 public:
  std::function<void(std::size_t block, PairSink& sink)> more;

  std::size_t begin(const BoxArray& boxes) override {
    boxes_ = &boxes;
    return 1;
  }
  std::size_t blocks(std::size_t) const override { return boxes_->size(); }
  void emit(std::size_t block, PairSink& sink) override {
    for (std::size_t k = block + 1; k < boxes_->size(); ++k)
      if (overlap((*boxes_)[block], (*boxes_)[k]))
        sink.put(static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(block));
    if (more) more(block, sink);
  }

 private:
  const BoxArray* boxes_ = nullptr;
};

/// Runs the stages one after the other; the blocks of the last one with two sinks in turn, from the last to the first.
class Backwards final : public Executor {
 public:
  std::function<void(ContactList&)> spoil;

  void run(StepWork& work, ContactList& contacts, ExecutionReport& report, std::stop_token, Timeline*) override {
    const std::size_t last = work.begin() - 1;
    for (std::size_t stage = 0; stage < last; ++stage)
      for (std::size_t block = work.blocks(stage); block-- > 0;) work.run(stage, block);
    NarrowingSink one(work, 7), other(work, 100);
    for (std::size_t block = work.blocks(last); block-- > 0;) work.emit(block, block % 2 == 0 ? one : other);
    one.flush();
    other.flush();
    report.candidate_pairs = one.candidates() + other.candidates();
    AnswerChunk* answers[] = {&one.answers(), &other.answers()};
    joiner_.join(answers, work.bodies(), contacts);
    if (spoil) spoil(contacts);
  }

 private:
  Joiner joiner_;
};

/// Moves the bodies and runs all pipelines: each must find what the first one finds.
std::size_t require_same(Scene scene, std::vector<Pipeline>& all, int steps) {
  Response response;
  std::size_t pairs = 0;
  for (int step = 0; step < steps; ++step) {
    std::uint64_t candidates = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      const StepReport report = all[i].step(scene);
      CAPTURE(step, i);
      REQUIRE(hash(all[i].contacts()) == hash(all[0].contacts()));
      if (i == 0) candidates = report.execution.candidate_pairs;
      REQUIRE(report.execution.candidate_pairs == candidates);
    }
    pairs += all[0].contacts().pairs.size();
    response.step(scene, all[0].contacts());
  }
  return pairs;
}

}  // namespace

TEST_CASE("sockets: a broad phase and an executor of one's own give the built-in ones' bits") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  std::size_t pairs = 0;
  for (const BuiltinScene& builtin : builtin_scenes())
    for (const double keep : {0.0, 1e-3}) {
      CAPTURE(builtin.name, keep);
      const Scene scene = test::settled_scene(builtin.name, 60, 30);
      std::vector<Pipeline> all;
      for (const ExecutorKind kind : {ExecutorKind::sequential, ExecutorKind::flowgraph, ExecutorKind::barrier})
        for (const int own : {0, 1, 2, 3}) {
          PipelineOptions options{.executor = kind, .threads = 3};
          options.answer = {.margin = recommended_margin(scene), .keep_contacts = keep};
          options.sharing.short_step_ms = 0;
          if ((own & 1) != 0) options.own_broad_phase = [] { return std::make_unique<Plain>(); };
          if ((own & 2) != 0) options.own_executor = [](const auto&) { return std::make_unique<Backwards>(); };
          all.emplace_back(options);
        }
      pairs += require_same(scene, all, 4);
    }
  CHECK(pairs > 1000);
}

TEST_CASE("sockets: what an own broad phase puts wrongly ends the step by a message, and the next step is whole") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  const Scene scene = test::settled_scene("cubes-on-plane", 60, 60);
  for (const ExecutorKind kind : executor_kinds)
    for (const double keep : {0.0, 1e-3}) {
      CAPTURE(name(kind), keep);
      std::function<void(std::size_t, PairSink&)> more;
      PipelineOptions options{.executor = kind, .threads = 3};
      options.answer = {.margin = 0.01, .keep_contacts = keep};
      options.sharing.short_step_ms = 0;
      Pipeline usual(options);
      usual.step(scene);
      REQUIRE(!usual.contacts().pairs.empty());
      const PairResult twice = usual.contacts().pairs.front();
      options.own_broad_phase = [&] {
        auto plain = std::make_unique<Plain>();
        plain->more = [&](std::size_t block, PairSink& sink) {
          if (more && block == 5) more(block, sink);
        };
        return plain;
      };
      const auto refused = [&](const std::function<void(std::size_t, PairSink&)>& wrong) {
        Pipeline pipeline(options);
        more = wrong;
        const std::string message = message_of([&] { pipeline.step(scene); });
        CHECK(pipeline.contacts().pairs.empty());
        more = {};
        pipeline.step(scene);
        CHECK(hash(pipeline.contacts()) == hash(usual.contacts()));
        return message;
      };
      CHECK(refused([](std::size_t, PairSink& sink) { sink.put(3, 4'000'000'000u); }) ==
            "own_broad_phase: block 5 put the pair (3, 4000000000), allowed: two different boxes of 61");
      CHECK(refused([](std::size_t, PairSink& sink) {
              sink.put_allowed({7, 7});
            }) == "own_broad_phase: block 5 put the pair (7, 7), allowed: two different boxes of 61");
      const std::string name = '(' + std::to_string(twice.a) + ", " + std::to_string(twice.b) + ')';
      CHECK(refused([&](std::size_t, PairSink& sink) { sink.put(twice.b, twice.a); }) ==
            "own_broad_phase: put the pair " + name + " twice, allowed: each pair once");
      // Far apart pairs are on no list; with kept answers, two threads might access the same data.
      if (keep == 0) continue;
      CHECK(refused([](std::size_t, PairSink& sink) {
              sink.put(1, 40);
              sink.put(40, 1);
            }) == "own_broad_phase: put the pair (1, 40) twice, allowed: each pair once");
    }
}

TEST_CASE("sockets: a list out of order, a part that is not there and one without stages are refused") {
  const Scene scene = test::settled_scene("cubes-on-plane", 60, 60);
  const Scene* looked = &scene;
  PipelineOptions options;
  std::function<void(ContactList&)> spoil = [](ContactList& list) { std::swap(list.pairs.front(), list.pairs.back()); };
  options.own_executor = [&](const ExecutorOptions& wanted) {
    CHECK(wanted.threads == 2);
    auto own = std::make_unique<Backwards>();
    own->spoil = [&](ContactList& list) { spoil(list); };
    return own;
  };
  options.threads = 2;
  Pipeline pipeline(options);
  CHECK(message_of([&] { pipeline.step(*looked); }).starts_with("own_executor: its list has the pair ("));
  CHECK(pipeline.contacts().pairs.empty());
  spoil = [](ContactList& list) { list.pairs.back().b = 4'000'000'000u; };
  CHECK(message_of([&] { pipeline.step(*looked); }).starts_with("own_executor: its list has a pair of no bodies"));
  spoil = [](ContactList& list) { list.pairs.back().first_contact += 1000; };
  CHECK(message_of([&] { pipeline.step(*looked); }).starts_with("own_executor: its list has a pair of no bodies"));
  CHECK(pipeline.contacts().contacts.empty());

  PipelineOptions none;
  none.own_executor = [](const ExecutorOptions&) { return std::unique_ptr<Executor>(); };
  CHECK(message_of([&] { const Pipeline made(none); }) == "own_executor: made none, allowed: an executor");
  none = {};
  none.own_broad_phase = [] { return std::unique_ptr<BroadPhase>(); };
  CHECK(message_of([&] { const Pipeline made(none); }) == "own_broad_phase: made none, allowed: a broad phase");
  none = {};
  none.own_costs = [] { return std::unique_ptr<CostModel>(); };
  CHECK(message_of([&] { const Pipeline made(none); }) == "own_costs: made none, allowed: a cost model");
}

TEST_CASE("sockets: a cost model of one's own is asked and told, and changes no bit") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  struct Model final : CostModel {
    explicit Model(std::atomic<int>* counts) : counts(counts) {}
    void begin_step(const Scene& scene) override { counts[0] += scene.bodies() > 0 ? 1 : 0; }
    std::chrono::nanoseconds guess(Pair pair) const override {
      ++counts[1];
      return std::chrono::microseconds(pair.b % 3 == 0 ? 100 : pair.b % 3 == 1 ? 5 : 0);
    }
    void took(std::span<const Pair> pairs, std::chrono::nanoseconds time) override {
      if (std::ranges::any_of(pairs, [](Pair pair) { return pair.b % 3 != 2; }) && time.count() >= 0) ++counts[2];
    }
    std::atomic<int>* counts;
  };
  const Scene scene = test::settled_scene("cubes-on-plane", 200, 40);
  std::atomic<int> counts[3] = {};
  std::vector<Pipeline> all;
  for (const StepForm form : {StepForm::caller, StepForm::overlapped, StepForm::ordered})
    for (const bool own : {false, true}) {
      PipelineOptions options{.threads = 3};
      options.answer.margin = recommended_margin(scene);
      options.sharing = {.form = form, .short_step_ms = 0};
      if (own) options.own_costs = [&] { return std::make_unique<Model>(counts); };
      all.emplace_back(options);
    }
  CHECK(require_same(scene, all, 3) > 0);
  CHECK(counts[0] == 9);
  CHECK(counts[1] > 0);
  CHECK(counts[2] > 0);
}

TEST_CASE("sockets: workers stay awake for a pipeline that asks; the contacts are the same") {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
  const Scene scene = test::settled_scene("cubes-on-plane", 200, 40);
  std::vector<Pipeline> all;
  for (const double microseconds : {0.0, 500.0, 5000.0})
    for (const int threads : {2, 4}) {
      PipelineOptions options{.threads = threads, .stay_awake = microseconds};
      options.answer.margin = recommended_margin(scene);
      all.emplace_back(options);
    }
  CHECK(require_same(scene, all, 8) > 0);
  CHECK(message_of([] { const Pipeline made({.stay_awake = -1}); }).starts_with("stay_awake: -1"));
}
