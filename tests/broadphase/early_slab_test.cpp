// Early pairs, and joint stages.
#include "kept_candidates/early_slab.h"

#include <new>

#include "box_worlds.h"
#include "catch.h"
#include "kept_candidates/joint_stages.h"
#include "trees/spatial_sample.h"

using namespace tandem;

TEST_CASE("early slab: its pairs and the later ones are all, each once") {
  EarlySlab slab;
  std::size_t taken = 0, with_pairs = 0;
  for (const BoxWorld& world : hard_worlds(20'000)) {
    CAPTURE(world.name);
    slab.choose(world.boxes, sample_boxes(world.boxes));
    if (!slab.taken()) continue;
    ++taken;
    const auto all = find_pairs(*make_broad_phase(BroadPhaseKind::sweep), world.boxes);
    ListSink early, rest;
    slab.emit(early);
    LaterPairs later(slab, world.boxes, rest);
    for (const Pair pair : all) later.put(pair.b, pair.a);
    later.flush();
    std::vector<std::vector<Pair>> found{early.take(), rest.take()};
    CHECK(20 * found[0].size() <= all.size() + 20);
    with_pairs += found[0].empty() ? 0 : 1;
    CHECK(sorted_pairs(found) == all);
    if (world.name == "random") CHECK(found[0].size() > 50);
  }
  CHECK(taken > 10);
  CHECK(with_pairs > 5);
}

TEST_CASE("early slab: the first block of a step from scratch and of one that makes a list hands on pairs") {
  const BoxArray boxes = hard_worlds(33'000)[0].boxes;
  for (const BroadPhaseKind kind : {BroadPhaseKind::grid, BroadPhaseKind::automatic}) {
    const auto method = make_broad_phase(kind);
    for (int step = 0; step < 2; ++step) {
      CAPTURE(name(kind), step);
      CHECK(pairs_of_blocks(*method, boxes, Order::forward).front().size() > 100);
    }
  }
}

TEST_CASE("joint stages: one that fails ends all") {
  JointStages stages;
  for (int turn = 0; turn < 50; ++turn) {
    stages.start(4, 8);
    const int bad = turn % 5;  // stage 2 has no blocks, 4 is none
    std::atomic<int> threw{0}, ended{0};
    std::atomic<std::size_t> ran{0};
    std::vector<std::thread> threads;
    for (int t = 0; t < 3; ++t)
      threads.emplace_back([&] {
        try {
          const bool done = stages.join([](std::size_t stage) { return stage == 2 ? 0u : 8u; },
                                        [&](std::size_t stage, std::size_t block) {
                                          ran += std::size_t{1} << (8 * stage);
                                          if (static_cast<int>(stage) == bad && block == 5) throw std::bad_alloc();
                                        });
          ended += done ? 1 : 0;
        } catch (const std::bad_alloc&) {
          ++threw;
        }
      });
    for (std::thread& thread : threads) thread.join();
    CAPTURE(bad);
    const bool fails = bad != 2 && bad != 4;
    CHECK(threw == (fails ? 1 : 0));
    CHECK(ended == (fails ? 0 : 3));
    if (!fails) CHECK(ran == (std::size_t{8} | std::size_t{8} << 8 | std::size_t{8} << 24));
    if (bad == 0) CHECK(ran < 256);
  }
}
