// The methods of the broad phase, compared with a double loop.
#include "tandem/broadphase/broad_phase.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "box_worlds.h"
#include "catch.h"

using namespace tandem;

namespace {

std::vector<Pair> all_overlaps(const BoxArray& boxes) {
  std::vector<Pair> pairs;
  for (std::uint32_t a = 0; a < boxes.size(); ++a)
    for (std::uint32_t b = a + 1; b < boxes.size(); ++b)
      if (overlap(boxes[a], boxes[b])) pairs.push_back({a, b});
  return pairs;
}

BoxArray random_boxes(std::size_t n, float extent, float size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> place(0, extent), edge(0, size);
  BoxArray boxes;
  boxes.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    Aabb box;
    for (std::size_t k = 0; k < 3; ++k) {
      box.lo[k] = place(random);
      box.hi[k] = box.lo[k] + edge(random);
    }
    boxes.set(i, box);
  }
  return boxes;
}

/// Unit cells side by side, shuffled: sorted input would hide a missing tie-break.
BoxArray touching_grid(int n, float cell) {
  std::vector<Aabb> cells;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const auto at = [&](int i) { return static_cast<float>(i) * cell; };
        cells.push_back({{at(x), at(y), at(z)}, {at(x + 1), at(y + 1), at(z + 1)}});
      }
  std::shuffle(cells.begin(), cells.end(), std::mt19937(7));
  BoxArray boxes;
  boxes.resize(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) boxes.set(i, cells[i]);
  return boxes;
}

constexpr BroadPhaseKind methods[] = {BroadPhaseKind::brute, BroadPhaseKind::sweep, BroadPhaseKind::grid,
                                      BroadPhaseKind::bvh, BroadPhaseKind::automatic};

}  // namespace

TEST_CASE("rounding outward: the float is never inside the double") {
  for (const double x : {0.1, -0.1, 1.0, 1e-50, -1e-50, 1e300, -1e300, 16777217.0, 0.0}) {
    CAPTURE(x);
    if (std::abs(x) < 1e38) CHECK(double{round_up(x)} >= x);
    if (std::abs(x) < 1e38) CHECK(double{round_down(x)} <= x);
    CHECK(std::isfinite(round_up(x)));
    CHECK(std::isfinite(round_down(x)));
  }
  constexpr float inf = std::numeric_limits<float>::infinity();
  for (const float f : {1.0f, -1.0f, 3.7e-39f, -3.7e-39f, 1e-45f, -1e-45f, 1e38f, -1e38f, 0.5f, -2.0f})
    for (const double off : {-1e-10, 0.0, 1e-10}) {
      const double x = double{f} * (1 + off);
      const float nearest = static_cast<float>(x);
      CAPTURE(x);
      CHECK(round_up(x) == (double{nearest} >= x ? nearest : std::nextafter(nearest, inf)));
      CHECK(round_down(x) == (double{nearest} <= x ? nearest : std::nextafter(nearest, -inf)));
    }
  CHECK(round_up(1.0) == 1.0f);
  CHECK(round_up(0.1) > round_down(0.1));
}

TEST_CASE("every broad phase finds the pairs of brute force on random boxes") {
  for (const BroadPhaseKind kind : methods)
    for (const std::size_t n : {0u, 1u, 2u, 7u, 8u, 9u, 63u, 64u, 65u, 1000u, 2049u, 5000u}) {
      CAPTURE(name(kind), n);
      const auto boxes = random_boxes(n, 20.0f, 1.5f, static_cast<unsigned>(n));
      const auto method = make_broad_phase(kind);
      const auto expected = all_overlaps(boxes);
      if (n >= 1000) REQUIRE(expected.size() > n / 20);
      CHECK(find_pairs(*method, boxes) == expected);
      CHECK(find_pairs(*method, boxes) == expected);  // a second step on the same object
    }
}

TEST_CASE("boxes that only touch are paired") {
  const int n = 12;
  for (const BroadPhaseKind kind : methods)
    for (const float cell : {1.0f, 0.125f, 1e-20f, 3e7f}) {
      CAPTURE(name(kind), cell);
      const auto boxes = touching_grid(n, cell);
      const auto pairs = find_pairs(*make_broad_phase(kind), boxes);
      // Along 3 axes, 6 face diagonals, 4 body diagonals: known without running the library.
      const auto expected = 3 * (n - 1) * n * n + 6 * (n - 1) * (n - 1) * n + 4 * (n - 1) * (n - 1) * (n - 1);
      CHECK(pairs.size() == static_cast<std::size_t>(expected));
      CHECK(std::adjacent_find(pairs.begin(), pairs.end()) == pairs.end());
    }
}

TEST_CASE("an unbounded ground, identical boxes and removed ones") {
  constexpr float big = std::numeric_limits<float>::max();
  auto boxes = random_boxes(3000, 30.0f, 1.0f, 3);
  boxes.set(17, {{-big, -big, -big}, {big, big, 0.5f}});
  for (std::size_t i = 100; i < 160; ++i) boxes.set(i, boxes[99]);
  for (std::size_t i = 200; i < 260; ++i) boxes.set_empty(i);
  const auto expected = all_overlaps(boxes);
  for (const BroadPhaseKind kind : methods) {
    CAPTURE(name(kind));
    CHECK(find_pairs(*make_broad_phase(kind), boxes) == expected);
  }
}

TEST_CASE("filters act before a pair exists") {
  const auto boxes = random_boxes(500, 5.0f, 1.0f, 11);
  std::vector<std::uint32_t> group(500), mask(500);
  std::vector<std::uint8_t> is_static(500);
  for (std::uint32_t i = 0; i < 500; ++i) {
    group[i] = 1u << (i % 3);
    mask[i] = i % 5 == 0 ? 0b001u : 0b111u;
    is_static[i] = i % 2 == 0;
  }
  const PairFilter filter{group, mask, is_static};
  std::vector<Pair> expected;
  for (const Pair p : all_overlaps(boxes))
    if (!(is_static[p.a] && is_static[p.b]) && (group[p.a] & mask[p.b]) && (group[p.b] & mask[p.a]))
      expected.push_back(p);
  REQUIRE(expected.size() > 50);
  for (const BroadPhaseKind kind : methods) {
    CAPTURE(name(kind));
    CHECK(find_pairs(*make_broad_phase(kind), boxes, filter) == expected);
  }
}

TEST_CASE("many boxes: in every world each method finds the pairs of brute force, on threads in the order of one") {
  // Enough for several blocks of every stage and for parallel sorts. Brute force itself is compared with plain loops.
  for (const BoxWorld& world : hard_worlds(33'000)) {
    const auto expected = find_pairs(*make_broad_phase(BroadPhaseKind::brute), world.boxes);
    if (world.name == "random") REQUIRE(expected.size() > 10'000);
    for (const BroadPhaseKind kind :
         {BroadPhaseKind::sweep, BroadPhaseKind::grid, BroadPhaseKind::bvh, BroadPhaseKind::automatic}) {
      const auto on_threads = make_broad_phase(kind), on_one = make_broad_phase(kind);
      // The first step is from scratch, the second makes a list, the third uses it.
      for (int step = 0; step < (kind == BroadPhaseKind::automatic ? 3 : 1); ++step) {
        CAPTURE(world.name, name(kind), step);
        const auto found = pairs_of_blocks(*on_threads, world.boxes, Order::threads);
        CHECK(sorted_pairs(found) == expected);
        CHECK((pairs_of_blocks(*on_one, world.boxes, Order::forward) == found));
      }
    }
  }
}
