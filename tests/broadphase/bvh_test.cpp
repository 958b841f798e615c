// The broad phase by a bounding volume hierarchy.
#include "methods/bvh.h"

#include "box_worlds.h"
#include "catch.h"

using namespace tandem;

TEST_CASE("bvh: worlds that break broad phases, small and odd sizes") {
  // One object for all: no data of an earlier step may matter.
  const auto method = make_broad_phase(BroadPhaseKind::bvh);
  for (const std::size_t n : {0u, 1u, 2u, 7u, 8u, 9u, 63u, 64u, 65u, 513u, 3000u, 1000u})
    for (const BoxWorld& world : hard_worlds(n)) {
      CAPTURE(world.name, n);
      CHECK(find_pairs(*method, world.boxes) == overlapping_pairs(world.boxes));
    }
}

TEST_CASE("bvh: boxes that only touch are paired") {
  const int n = 20;
  for (const float cell : {1.0f, 0.1f, 1e-20f, 3e7f}) {
    CAPTURE(cell);
    const BoxArray boxes = touching_cells(n, cell);
    const auto pairs = find_pairs(*make_broad_phase(BroadPhaseKind::bvh), boxes);
    CHECK(pairs.size() == touching_cells_pairs(n));
    CHECK(pairs == overlapping_pairs(boxes));
  }
}

TEST_CASE("bvh: the same pairs from the same blocks in any order and on threads") {
  for (const BoxWorld& world : hard_worlds(20000)) {
    if (world.name != "random" && world.name != "an unbounded ground" && world.name != "clusters" &&
        world.name != "six decades of size")
      continue;
    CAPTURE(world.name);
    const auto method = make_broad_phase(BroadPhaseKind::bvh);
    const auto forward = pairs_of_blocks(*method, world.boxes, Order::forward);
    CHECK(forward.size() > 8);
    CHECK(sorted_pairs(forward) == overlapping_pairs(world.boxes));
    for (const Order order : {Order::reversed, Order::shuffled, Order::threads, Order::forward})
      CHECK((pairs_of_blocks(*method, world.boxes, order) == forward));
  }
}

TEST_CASE("bvh: a tree over some of the boxes answers queries of the others") {
  for (const BoxWorld& world : hard_worlds(3000)) {
    CAPTURE(world.name);
    std::vector<std::uint32_t> members;
    for (std::uint32_t i = 0; i < world.boxes.size(); i += 3) members.push_back(i);
    BoxTree tree;
    tree.begin(world.boxes, &members);
    for (std::size_t stage = 0; stage < BoxTree::build_stages; ++stage)
      for (std::size_t block = 0; block < tree.blocks(stage); ++block) tree.run(stage, block);
    ListSink sink;
    for (std::uint32_t i = 0; i < world.boxes.size(); ++i)
      if (i % 3 != 0) tree.query(world.boxes[i], i, sink);
    std::vector<Pair> expected;
    for (const Pair p : overlapping_pairs(world.boxes))
      if ((p.a % 3 == 0) != (p.b % 3 == 0)) expected.push_back(p);
    CHECK(sorted_pairs({sink.take()}) == expected);
  }
}

TEST_CASE("bvh: identical boxes make every pair once") {
  BoxArray boxes;
  boxes.resize(1500);
  for (std::size_t i = 0; i < boxes.size(); ++i) boxes.set(i, {{1, 2, 3}, {2, 3, 4}});
  const auto pairs = find_pairs(*make_broad_phase(BroadPhaseKind::bvh), boxes);
  CHECK(pairs.size() == 1500 * 1499 / 2);
  CHECK(std::adjacent_find(pairs.begin(), pairs.end()) == pairs.end());
}
