// The broad phase by a grid.
#include "methods/grid.h"

#include "box_worlds.h"
#include "catch.h"
#include "trees/spatial_sample.h"

using namespace tandem;

TEST_CASE("grid: worlds that break broad phases, small and odd sizes") {
  const auto method =
      make_broad_phase(BroadPhaseKind::grid);  // one object for all: no data of an earlier step may matter
  for (const std::size_t n : {0u, 1u, 2u, 7u, 8u, 9u, 63u, 64u, 65u, 513u, 3000u, 1000u})
    for (const BoxWorld& world : hard_worlds(n)) {
      CAPTURE(world.name, n);
      CHECK(find_pairs(*method, world.boxes) == overlapping_pairs(world.boxes));
    }
}

TEST_CASE("grid: boxes that only touch are paired") {
  const int n = 20;
  for (const float cell : {1.0f, 0.1f, 1e-20f, 3e7f}) {
    CAPTURE(cell);
    const BoxArray boxes = touching_cells(n, cell);
    const auto pairs = find_pairs(*make_broad_phase(BroadPhaseKind::grid), boxes);
    CHECK(pairs.size() == touching_cells_pairs(n));
    CHECK(pairs == overlapping_pairs(boxes));
  }
}

TEST_CASE("grid: the same pairs from the same blocks in any order and on threads") {
  // 20000 boxes give several blocks in every stage; the worlds use the columns, rows of large boxes and the tree.
  for (const BoxWorld& world : hard_worlds(20000)) {
    if (world.name != "random" && world.name != "an unbounded ground" && world.name != "two tight clusters, far apart")
      continue;
    CAPTURE(world.name);
    const auto method = make_broad_phase(BroadPhaseKind::grid);
    const auto forward = pairs_of_blocks(*method, world.boxes, Order::forward);
    CHECK(forward.size() > 8);
    CHECK(sorted_pairs(forward) == overlapping_pairs(world.boxes));
    for (const Order order : {Order::reversed, Order::shuffled, Order::threads, Order::forward})
      CHECK((pairs_of_blocks(*method, world.boxes, order) == forward));
  }
}

TEST_CASE("grid: leaves to the tree what columns are wrong for, and only that") {
  Grid grid;
  bool saw_crowded = false;
  for (const BoxWorld& world : hard_worlds(20000)) {
    CAPTURE(world.name);
    (void)find_pairs(grid, world.boxes);
    if (world.name == "random" || world.name == "sparse" || world.name == "plane" || world.name == "line") {
      CHECK_FALSE(grid.unfit().crowded);
      CHECK(grid.unfit().large == 0);
    }
    if (world.name == "two tight clusters, far apart") CHECK(grid.unfit().crowded);
    saw_crowded = saw_crowded || grid.unfit().crowded;
  }
  CHECK(saw_crowded);
}

TEST_CASE("grid: large boxes in rows while few, by the tree when many") {
  for (const std::size_t large : {5u, 64u, 65u, 100u}) {
    CAPTURE(large);
    auto boxes = hard_worlds(20000)[0].boxes;  // a cube of edge 54
    // None of them is in the sample from which the widths are chosen: otherwise a few wide columns may be the better
    // choice.
    BoxArray numbered;
    numbered.resize(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const auto x = static_cast<float>(i);
      numbered.set(i, {{x, x, x}, {x, x, x}});
    }
    std::vector<bool> sampled(boxes.size());
    for (const Aabb& box : sample_boxes(numbered)) sampled[static_cast<std::size_t>(box.lo[0])] = true;
    for (std::size_t i = 0, made = 0; made < large; i += 37) {
      if (sampled[i]) continue;
      const auto at = static_cast<float>(made++ % 20);
      boxes.set(i, {{at, at, at}, {at + 50, at + 50, at + 50}});
    }
    Grid grid;
    const auto found = pairs_of_blocks(grid, boxes, Order::forward);
    CHECK(grid.unfit().large == large);
    CHECK_FALSE(grid.unfit().crowded);
    CHECK(sorted_pairs(found) == overlapping_pairs(boxes));
    CHECK((pairs_of_blocks(grid, boxes, Order::threads) == found));
  }
}

TEST_CASE("grid: a search after a step finds what overlaps a box, once") {
  Grid grid;
  for (const BoxWorld& world : hard_worlds(3000)) {
    CAPTURE(world.name);
    const std::size_t stages = grid.begin(world.boxes);
    grid.prepare_search();
    ListSink ignored;
    for (std::size_t stage = 0; stage + 1 < stages; ++stage)
      for (std::size_t block = 0; block < grid.blocks(stage); ++block) grid.run(stage, block);
    for (std::size_t block = 0; block < grid.blocks(stages - 1); ++block) grid.emit(block, ignored);
    for (std::uint32_t i = 0; i < 3000; i += 60) {
      const Aabb box = world.boxes[i];
      if (box.lo[0] > box.hi[0]) continue;
      ListSink sink;
      grid.search(box, 100'000, sink);
      std::vector<Pair> expected;
      for (std::uint32_t j = 0; j < 3000; ++j)
        if (overlap(box, world.boxes[j])) expected.push_back({j, 100'000});
      CHECK(sorted_pairs({sink.take()}) == expected);
    }
  }
}

TEST_CASE("grid: slices by vectors are those by one") {
  Random random(3);
  std::vector<float> x(1000 + BoxArray::padding);
  std::vector<std::uint16_t> found(x.size());
  constexpr float inf = std::numeric_limits<float>::infinity();
  for (float& value : x) value = uniform(random, -2, 12) * std::pow(10.0f, std::floor(uniform(random, 0, 3)));
  x[3] = inf, x[4] = -inf, x[5] = std::numeric_limits<float>::max(), x[6] = -x[5], x[7] = 0;
  for (const Slices& slices : {Slices{0, 0, 0, 1}, Slices{0, 0, 1, 16384}, Slices{0, 1, 0.37f, 300},
                               Slices{0, -3e37f, 1e-37f, 7}, Slices{0, 0, 0, 9}}) {
    slices_of(slices, x.data(), 1000, found.data());
    for (std::size_t i = 0; i < 1000; ++i) {
      CAPTURE(x[i], slices.count);
      CHECK(found[i] == slices.at(x[i]));
    }
  }
}

TEST_CASE("grid: identical boxes make every pair once") {
  BoxArray boxes;
  boxes.resize(1500);
  for (std::size_t i = 0; i < boxes.size(); ++i) boxes.set(i, {{1, 2, 3}, {2, 3, 4}});
  const auto pairs = find_pairs(*make_broad_phase(BroadPhaseKind::grid), boxes);
  CHECK(pairs.size() == 1500 * 1499 / 2);
  CHECK(std::adjacent_find(pairs.begin(), pairs.end()) == pairs.end());
}
