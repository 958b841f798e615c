// The pipeline: executors, filters, callbacks, changes of the scene.
#include "tandem/engine/pipeline.h"

#include <oneapi/tbb/flow_graph.h>
#include <oneapi/tbb/global_control.h>

#include "catch.h"
#include "narrowphase/random_pairs.h"
#include "scene/mesh_generators.h"
#include "scene/random.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/response.h"
#include "tandem/narrowphase/shape_makers.h"

using namespace tandem;

namespace {

std::vector<PipelineOptions> all_setups(const PipelineOptions& base) {
  std::vector<PipelineOptions> setups;
  for (const ExecutorKind kind : executor_kinds)
    for (const int threads : {1, 2, 3, 8}) {
      PipelineOptions options = base;
      options.executor = kind;
      options.threads = threads;
      options.sharing.short_step_ms = 0;
      options.answer.contact_hash = true;
      setups.push_back(options);
      if (kind == ExecutorKind::sequential) break;
      if (kind == ExecutorKind::barrier || kind == ExecutorKind::fused || threads == 1) continue;
      for (const int broad : {1, threads / 2, threads - 1}) {
        options.balance.split = {broad, threads - broad};
        setups.push_back(options);
        options.balance.strict = true;
        if (kind == ExecutorKind::flowgraph) setups.push_back(options);
        options.balance.strict = false;
      }
    }
  return setups;
}

}  // namespace

TEST_CASE("every executor, thread count and split gives the sequential contacts on every scene") {
  // A small machine limits oneTBB to its number of cores; without this the cases of more threads would test nothing
  // new.
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  for (const BuiltinScene& builtin : builtin_scenes()) {
    CAPTURE(builtin.name);
    Scene scene = make_builtin_scene(builtin.name, 60);
    const auto setups = all_setups({.answer = {.margin = recommended_margin(scene)}});
    std::vector<Pipeline> pipelines;
    for (const PipelineOptions& setup : setups) pipelines.emplace_back(setup);
    Response response;
    std::uint64_t contacts = 0;
    for (int step = 0; step < 61; ++step) {
      const bool compare = step % 15 == 0;
      std::uint64_t expected = 0;
      for (std::size_t i = 0; i < setups.size(); ++i) {
        const StepReport report = pipelines[i].step(scene);
        if (i == 0) expected = report.contact_hash, contacts += report.contacts;
        CAPTURE(step, name(setups[i].executor), setups[i].threads, setups[i].balance.split.broad,
                setups[i].balance.strict);
        if (report.contact_hash != expected) FAIL_CHECK("other contacts than sequential");
        if (!compare) break;
      }
      response.step(scene, pipelines.front().contacts());
    }
    // A test on nothing would pass, too.
    if (builtin.name != "falling-apart") CHECK(contacts > 100);
  }
}

TEST_CASE("every broad phase and every request: one answer for all executors") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  Scene scene = make_builtin_scene("tori-and-cubes", 120);
  Pipeline mover;
  Response response;
  for (int step = 0; step < 60; ++step) {
    mover.step(scene);
    response.step(scene, mover.contacts());
  }
  for (const Request request : {Request::collide, Request::distance, Request::contacts}) {
    std::uint64_t expected = 0;
    for (const BroadPhaseKind broad : {BroadPhaseKind::brute, BroadPhaseKind::sweep, BroadPhaseKind::grid,
                                       BroadPhaseKind::bvh, BroadPhaseKind::automatic}) {
      PipelineOptions base;
      base.broad_phase = broad;
      base.answer.request = request;
      for (const PipelineOptions& setup : all_setups(base)) {
        Pipeline pipeline(setup);
        const StepReport report = pipeline.step(scene);
        CAPTURE(name(request), name(broad), name(setup.executor), setup.threads);
        if (expected == 0) {
          expected = report.contact_hash;
          REQUIRE(report.colliding_pairs > 20);
        }
        CHECK(report.contact_hash == expected);
      }
    }
  }
}

TEST_CASE("two meshes of many triangles among spheres: one answer for all executors") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  Scene scene;
  const ShapeId ring = scene.add_shape(Shape(make_torus(1, 0.4, 100, 50))), ball = scene.add_shape(Shape(Sphere{0.2}));
  const auto add = [&](ShapeId shape, const Vec3& at) {
    BodyOptions body;
    body.shape = shape;
    body.pose.translation = at;
    scene.add_body(body);
  };
  add(ring, Vec3(0, 0, 0));
  add(ring, Vec3(1.1, 0.05, 0.1));
  for (int i = 0; i < 600; ++i) add(ball, Vec3(0.3 * (i % 10), 3 + 0.3 * (i / 10 % 10), 0.3 * (i / 100)));
  std::uint64_t expected = 0;
  for (const PipelineOptions& setup : all_setups({})) {
    Pipeline pipeline(setup);
    for (int step = 0; step < 2; ++step) {
      const StepReport report = pipeline.step(scene);
      if (expected == 0) expected = report.contact_hash;
      CAPTURE(name(setup.executor), setup.threads, setup.balance.split.broad, setup.balance.strict);
      CHECK(report.contact_hash == expected);
      CHECK(report.contacts > 600);
    }
  }
}

namespace {

/// Two balls that touch, then two rings of many triangles deep in each other.
Scene balls_and_rings() {
  Scene scene;
  const ShapeId ring = scene.add_shape(Shape(make_torus(1, 0.4, 200, 100))), ball = scene.add_shape(Shape(Sphere{0.2}));
  scene.add_body({.shape = ball, .pose = Pose::at(0, 0, 9)});
  scene.add_body({.shape = ball, .pose = Pose::at(0.3, 0, 9)});
  scene.add_body({.shape = ring});
  scene.add_body({.shape = ring, .pose = Pose::from(Quat(0.9, 0.1, 0.3, 0.2), {0.3, 0.2, 0.1})});
  return scene;
}

bool has(const StepReport& report, StepIssue issue) { return (report.execution.issues & bit(issue)) != 0; }

}  // namespace

TEST_CASE("bodies of all kinds that fall on voxels come to rest on them: one answer for all executors") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  Scene scene;
  std::vector<std::uint8_t> floor(40 * 40 * 3, 1);
  test::Random random(17);
  for (std::size_t i = 2 * 40 * 40; i < floor.size(); ++i) floor[i] = random.in(0, 1) < 0.2;
  const ShapeId ground = scene.add_shape(occupancy_grid(floor, {40, 40, 3}, 0.25, Vec3(-5, -5, -0.75)));
  scene.add_body({.shape = ground, .is_static = true});
  std::vector<std::array<std::int32_t, 3>> bar{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}};
  const ShapeId shapes[] = {scene.add_shape(Sphere{0.2}), scene.add_shape(Box{{0.4, 0.5, 0.3}}),
                            scene.add_shape(Capsule{0.1, 0.4}), scene.add_shape(voxels(bar, 0.2))};
  for (int i = 0; i < 48; ++i) {
    Pose pose = test::random_pose(random, 3.5);
    pose.translation.z() = 0.8 + 0.05 * i;
    scene.add_body({.shape = shapes[i % 4], .pose = pose});
  }
  const auto setups = all_setups({.answer = {.margin = recommended_margin(scene)}});
  std::vector<Pipeline> pipelines;
  for (const PipelineOptions& setup : setups) pipelines.emplace_back(setup);
  Response response;
  std::uint64_t contacts = 0;
  for (int step = 0; step < 150; ++step) {
    std::uint64_t expected = 0;
    for (std::size_t i = 0; i < (step % 30 == 29 ? setups.size() : 1); ++i) {
      const StepReport report = pipelines[i].step(scene);
      if (i == 0) expected = report.contact_hash, contacts += report.contacts;
      CAPTURE(step, name(setups[i].executor), setups[i].threads);
      CHECK(report.contact_hash == expected);
    }
    response.step(scene, pipelines.front().contacts());
  }
  CHECK(contacts > 1000);
  for (std::uint32_t body = 1; body < scene.indices(); ++body) CHECK(scene.poses()[body].translation.z() > -0.3);
}

TEST_CASE("a step whose deadline has passed marks every pair it lists, and the next one is whole") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  const Scene scene = balls_and_rings();
  Pipeline reference({.executor = ExecutorKind::sequential, .answer = {.contact_hash = true}});
  const std::uint64_t expected = reference.step(scene).contact_hash;
  for (const double kept : {0.0, 1e-3})
    for (const ExecutorKind kind : executor_kinds) {
      CAPTURE(name(kind), kept);
      Pipeline pipeline({.executor = kind,
                         .threads = 3,
                         .answer = {.keep_contacts = kept, .contact_hash = true},
                         .sharing = {.short_step_ms = 0}});
      CHECK(!has(pipeline.step(scene), StepIssue::incomplete));
      const StepReport late = pipeline.step(scene, {}, std::chrono::steady_clock::now());
      CHECK(has(late, StepIssue::incomplete));
      CHECK(!has(late, StepIssue::ended_early));
      CHECK(late.contacts == 0);
      for (const PairResult& pair : pipeline.contacts().pairs) CHECK(pair.answer.status == Status::stopped);
      const StepReport next = pipeline.step(scene, {}, std::chrono::steady_clock::now() + std::chrono::hours(1));
      CHECK(next.contact_hash == expected);
      CHECK(!has(next, StepIssue::incomplete));
      CHECK(next.colliding_pairs == 2);
    }
}

TEST_CASE("a step that has no time builds no hull of a mesh, and the next one is whole") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  Pipeline reference({.executor = ExecutorKind::sequential, .answer = {.contact_hash = true}});
  const std::uint64_t expected = reference.step(balls_and_rings()).contact_hash;
  std::stop_source stopped;
  stopped.request_stop();
  for (const bool by_stop : {false, true})
    for (const double kept : {0.0, 1e-3})
      for (const ExecutorKind kind : executor_kinds) {
        CAPTURE(name(kind), kept, by_stop);
        const Scene scene = balls_and_rings();
        Pipeline pipeline({.executor = kind,
                           .threads = 3,
                           .answer = {.keep_contacts = kept, .contact_hash = true},
                           .sharing = {.short_step_ms = 0}});
        const StepReport late = by_stop ? pipeline.step(scene, stopped.get_token())
                                        : pipeline.step(scene, {}, std::chrono::steady_clock::now());
        CHECK(has(late, by_stop ? StepIssue::ended_early : StepIssue::incomplete));
        CHECK(pipeline.contacts().pairs.empty());
        CHECK(scene.shapes()[0].kind() == ShapeKind::mesh);
        CHECK(scene.shapes()[0].memory_by_part().hull == 0);
        CHECK(pipeline.step(scene).contact_hash == expected);
        CHECK(scene.shapes()[0].memory_by_part().hull > 0);
      }
}

TEST_CASE("a deadline that passes within a pair ends it there: what was finished before is told, the pair is marked") {
  const Scene scene = balls_and_rings();
  Pipeline pipeline({.executor = ExecutorKind::sequential, .answer = {.contact_hash = true}});
  pipeline.step(scene);
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const std::uint64_t whole = pipeline.step(scene).contact_hash;
  const auto took = Clock::now() - begin;
  // Whether the deadline passes within the second pair depends on the machine; nearly all of the step is that pair.
  bool seen = false;
  for (int i = 0; i < 50 && !seen; ++i) {
    const StepReport report = pipeline.step(scene, {}, Clock::now() + took * (1 + i % 5) / 8);
    const std::vector<PairResult>& pairs = pipeline.contacts().pairs;
    seen = pairs.size() == 2 && pairs[0].answer.status == Status::ok && pairs[1].answer.status == Status::stopped;
    if (!seen) continue;
    CHECK(has(report, StepIssue::incomplete));
    CHECK((report.colliding_pairs == 1 && report.contacts == 1));
    CHECK((pairs[1].contact_count == 0 && !pairs[1].answer.collide));
    CHECK(pipeline.contacts().of(pairs[0]).size() == 1);
  }
  CHECK(seen);
  CHECK(pipeline.step(scene).contact_hash == whole);
}

TEST_CASE("a step as a node of the host's own flow graph") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 4);
  Scene scene = make_builtin_scene("cubes-on-plane", 100);
  Pipeline reference({.executor = ExecutorKind::sequential, .answer = {.contact_hash = true}});
  const std::uint64_t expected = reference.step(scene).contact_hash;
  Pipeline pipeline({.threads = 3, .answer = {.contact_hash = true}, .sharing = {.short_step_ms = 0}});
  std::vector<std::uint64_t> hashes;
  tbb::flow::graph host;
  tbb::flow::function_node<int> node(host, tbb::flow::serial,
                                     [&](int) { hashes.push_back(pipeline.step(scene).contact_hash); });
  for (int i = 0; i < 10; ++i) node.try_put(i);
  host.wait_for_all();
  CHECK(hashes == std::vector<std::uint64_t>(10, expected));
}

TEST_CASE("groups, masks and a predicate keep pairs away from the narrow phase") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  for (int i = 0; i < 20; ++i)
    scene.add_body(
        {.shape = ball, .pose = Pose::at(0.1 * i, 0, 0), .is_static = i < 5, .group = i % 2 ? 1u : 2u, .mask = 1u});
  Pipeline pipeline;
  const StepReport report = pipeline.step(scene);
  // Bodies of group 1 collide with each other, except two static ones: 10 odd ones, 2 of them (1, 3) static.
  CHECK(report.execution.candidate_pairs == 10 * 9 / 2 - 1);
  CHECK(report.colliding_pairs == 10 * 9 / 2 - 1);
  for (const PairResult& pair : pipeline.contacts().pairs) CHECK((pair.a % 2 == 1 && pair.b % 2 == 1));

  Pipeline none({.predicate = [](std::span<Pair>) { return std::size_t{0}; }});
  CHECK(none.step(scene).colliding_pairs == 0);
  Pipeline wrong({.predicate = [](std::span<Pair> pairs) { return pairs.size() + 1; }});
  CHECK_THROWS_WITH(wrong.step(scene), Catch::Matchers::Contains("predicate"));
}

TEST_CASE("pairs that a predicate makes up, of bodies that there are not or of one body, end the step") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  for (int i = 0; i < 5; ++i) scene.add_body({.shape = ball, .pose = Pose::at(i, 0, 0)});
  scene.remove_body(scene.id(4));
  for (const ExecutorKind kind : executor_kinds)
    for (const Pair made : {Pair{4, 1}, Pair{5, 1}, Pair{1, 4'000'000'000u}, Pair{2, 2}}) {
      PipelineOptions options{.executor = kind, .threads = 2};
      bool is_on = true;
      options.predicate = [&](std::span<Pair> pairs) {
        if (is_on) pairs.front() = made;
        return pairs.size();
      };
      Pipeline pipeline(options);
      CHECK_THROWS_WITH(pipeline.step(scene), Catch::Matchers::StartsWith("predicate: kept the pair ("));
      CHECK(pipeline.contacts().pairs.empty());
      is_on = false;
      pipeline.step(scene);
      CHECK(pipeline.contacts().pairs.size() == 5);  // of neighbours, and of those two apart, which touch
    }
}

TEST_CASE("pairs that a predicate turns round are answered so, by every executor") {
  const tbb::global_control many(tbb::global_control::max_allowed_parallelism, 8);
  const Scene scene = make_builtin_scene("complex-in-contact", 30);
  const auto turn = [](std::span<Pair> pairs) {
    for (Pair& pair : pairs)
      if ((pair.a + pair.b) % 2 == 1) std::swap(pair.a, pair.b);
    return pairs.size();
  };
  std::uint64_t expected = 0;
  for (PipelineOptions setup : all_setups({})) {
    setup.predicate = turn;
    Pipeline pipeline(setup);
    const StepReport report = pipeline.step(scene);
    if (expected == 0) expected = report.contact_hash;
    CAPTURE(name(setup.executor), setup.threads);
    CHECK(report.contact_hash == expected);
    CHECK(report.colliding_pairs > 20);
    for (const PairResult& pair : pipeline.contacts().pairs) CHECK((pair.a > pair.b) == ((pair.a + pair.b) % 2 == 1));
  }
}

TEST_CASE("an empty scene, removed bodies and bodies added between steps") {
  Scene scene;
  Pipeline pipeline({.sharing = {.short_step_ms = 0}});
  CHECK(pipeline.step(scene).contacts == 0);
  const ShapeId ball = scene.add_shape(Sphere{1});
  const BodyId first = scene.add_body({.shape = ball});
  const BodyId second = scene.add_body({.shape = ball, .pose = Pose::at(1.5, 0, 0)});
  CHECK(pipeline.step(scene).colliding_pairs == 1);
  REQUIRE(pipeline.contacts().contacts.size() == 1);
  CHECK(pipeline.contacts().contacts[0].depth == Approx(0.5));
  CHECK(pipeline.contacts().contacts[0].normal.x() == Approx(1));
  scene.remove_body(first);
  CHECK(pipeline.step(scene).colliding_pairs == 0);
  scene.add_body({.shape = ball, .pose = Pose::at(3, 0, 0)});
  CHECK(pipeline.step(scene).colliding_pairs == 1);
  scene.remove_body(second);
  CHECK(pipeline.step(scene).bodies == 1);
}

TEST_CASE("the margin reports gaps as negative depths, and no further") {
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  scene.add_body({.shape = ball});
  scene.add_body({.shape = ball, .pose = Pose::at(2.05, 0, 0)});
  Pipeline exact;
  CHECK(exact.step(scene).gaps == 0);
  Pipeline near({.answer = {.margin = 0.1}});
  const StepReport report = near.step(scene);
  CHECK(report.contacts == 0);
  REQUIRE(report.gaps == 1);
  CHECK(report.colliding_pairs == 0);
  CHECK(near.contacts().contacts[0].depth == Approx(-0.05));
  Pipeline nearer({.answer = {.margin = 0.01}});
  CHECK(nearer.step(scene).gaps == 0);
}

TEST_CASE("bad pipeline options are refused with what was found and what is allowed") {
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(Pipeline({.threads = 5000}), Contains("threads: 5000") && Contains("1024"));
  CHECK_THROWS_WITH(Pipeline({.threads = 4, .balance = {.split = {1, 1}}}), Contains("balance.split: 1-1"));
  CHECK_THROWS_WITH(Pipeline({.answer = {.tolerance = -1}}), Contains("answer.tolerance: -1"));
  CHECK_THROWS_WITH(Pipeline({.answer = {.margin = std::nan("")}}), Contains("answer.margin: nan"));
  CHECK_THROWS_WITH(Pipeline({.batches = {.pairs = 0}}), Contains("batches.pairs: 0"));
}

TEST_CASE("what stands still is not looked at again, whatever is done to a scene between steps") {
  for (const double keep : {0.0, 1e-3}) {
    Scene scene;
    scene.request = Request::contacts;
    const ShapeId ball = scene.add_shape(Sphere{1}), cube = scene.add_shape(Box{Vec3(2, 2, 2)});
    std::uint64_t state = 1;
    const auto draw = [&](std::uint32_t below) {
      state = state * 6364136223846793005u + 1442695040888963407u;
      return static_cast<std::uint32_t>(state >> 33) % below;
    };
    const auto anywhere = [&] { return Pose::at(0.1 * draw(200), 0.1 * draw(200), 0.1 * draw(20)); };
    const auto body = [&] {
      return BodyOptions{.shape = draw(2) != 0 ? ball : cube,
                         .pose = anywhere(),
                         .is_static = draw(4) != 0,
                         .group = 1u << draw(3),
                         .mask = 7u & ~(1u << draw(3))};
    };
    for (int i = 0; i < 400; ++i) scene.add_body(body());
    Pipeline pipeline({.answer = {.keep_contacts = keep, .contact_hash = true}, .sharing = {.short_step_ms = 0}});
    Scene copy = scene;
    std::size_t pairs = 0;
    for (int step = 0; step < 60; ++step) {
      CAPTURE(keep, step);
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t index = draw(400);
        switch (step % 10) {
          case 3:
            if (scene.alive(index)) scene.set_pose(scene.id(index), anywhere());
            break;
          case 5:  // another body in the same slot, with other groups
            if (scene.alive(index)) {
              BodyOptions other = body();
              other.pose = scene.poses()[index];
              scene.remove_body(scene.id(index));
              scene.add_body(other);
            }
            break;
          case 7:
            if (scene.alive(index)) scene.remove_body(scene.id(index));
            break;
          case 9:
            scene.add_body(body());
            break;
          default:
            if (scene.alive(index)) scene.move(index, anywhere(), Vec3::Zero(), Vec3::Zero());
        }
      }
      if (step % 20 == 12) copy = scene;
      // In some steps the pipeline is given a copy of the scene, once equal, that has changed since.
      if (step % 20 == 15 || step % 20 == 16) {
        for (std::uint32_t i = 0; i < 30; ++i) copy.move(i, anywhere(), Vec3::Zero(), Vec3::Zero());
        std::swap(copy, scene);
      }
      Pipeline fresh({.answer = {.keep_contacts = keep, .contact_hash = true}, .sharing = {.short_step_ms = 0}});
      const StepReport expected = fresh.step(scene), report = pipeline.step(scene);
      REQUIRE(report.execution.candidate_pairs == expected.execution.candidate_pairs);
      REQUIRE(report.colliding_pairs == expected.colliding_pairs);
      if (keep == 0) REQUIRE(report.contact_hash == expected.contact_hash);
      pairs += report.colliding_pairs;
    }
    CHECK(pairs > 1000);
  }
}

TEST_CASE("spheres that all move and now and then change shape or filter: the contacts of a new pipeline") {
  constexpr std::uint32_t n = 1200;
  Random random(11);
  Scene scene;
  const ShapeId small = scene.add_shape(Sphere{0.3}), large = scene.add_shape(Sphere{0.5}),
                box = scene.add_shape(Box{{0.6, 0.6, 0.6}});
  ShapeId own = small;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double x = i % 11, y = i / 11 % 11, z = i / 121;
    if (i % 3 == 0) own = scene.add_shape(Sphere{0.3 + 0.1 * random.uniform(0, 1)});
    scene.add_body({.shape = i % 3 == 0 ? own : small, .pose = Pose::at(0.6 * x, 0.6 * y, 0.6 * z)});
  }
  const auto body = [&] { return scene.id(static_cast<std::uint32_t>(random.bits() % n)); };
  Pipeline pipeline({.executor = ExecutorKind::sequential, .answer = {.contact_hash = true}});
  std::uint64_t pairs = 0;
  int kept = 0;
  for (int step = 0; step < 60; ++step) {
    CAPTURE(step);
    for (std::uint32_t i = 0; i < n; ++i)
      scene.move(i, Pose{Mat3::Identity(), scene.poses()[i].translation + Vec3(0, 0, 1e-3 * (i % 7))}, Vec3::Zero(),
                 Vec3::Zero());
    if (step % 7 == 3) scene.set_shape(body(), large);
    if (step % 7 == 5) scene.set_shape(body(), box);
    if (step % 11 == 4) scene.set_filter(body(), 1, 0);
    if (step == 30) scene.replace_shape(own, Sphere{0.45});
    Pipeline fresh(
        {.executor = ExecutorKind::sequential, .broad_phase = BroadPhaseKind::brute, .answer = {.contact_hash = true}});
    const StepReport expected = fresh.step(scene), report = pipeline.step(scene);
    REQUIRE(report.execution.candidate_pairs == expected.execution.candidate_pairs);
    REQUIRE(report.contact_hash == expected.contact_hash);
    pairs += report.colliding_pairs;
    kept += report.broad_phase_reason.find("kept") != std::string_view::npos ? 1 : 0;
  }
  CHECK(pairs > 60 * n / 2);
  CHECK(kept > 20);
}
