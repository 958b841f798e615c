// Sets of boxes by slabs against a plain loop, and batches of worlds of more bodies than are kept so.
#include "queries/interval_bits.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "catch.h"
#include "narrowphase/random_pairs.h"
#include "tandem/engine/scene_queries.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using namespace tandem::test;

namespace {

Aabb random_box(Random& random, double spread, double size) {
  Aabb box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.lo[k] = static_cast<float>(random.in(-spread, spread));
    box.hi[k] = box.lo[k] + static_cast<float>(random.in(0, size));
  }
  return box;
}

/// Which boxes are visited for a box; they must hold those that overlap.
std::vector<std::uint32_t> near(const IntervalBits& bits, const IntervalBits::Ends& ends) {
  std::vector<std::uint32_t> found;
  bits.visit_near(ends, [&](std::uint32_t index) {
    found.push_back(index);
    return true;
  });
  return found;
}

void compare(const IntervalBits& bits, const BoxArray& boxes, const BoxArray& asked) {
  IntervalBits::EndsOfBoxes ends;
  bits.find_ends(asked, asked.size(), ends);
  std::size_t visited = 0, overlapping = 0;
  for (std::size_t q = 0; q < asked.size(); ++q) {
    REQUIRE(ends[q] == bits.ends_of(asked[q]));
    const std::vector<std::uint32_t> found = near(bits, ends[q]);
    REQUIRE(std::is_sorted(found.begin(), found.end()));
    for (std::uint32_t i = 0; i < boxes.size(); ++i) {
      const bool overlaps = overlap(boxes[i], asked[q]);
      if (overlaps) REQUIRE(std::binary_search(found.begin(), found.end(), i));
      overlapping += overlaps;
    }
    visited += found.size();
  }
  CHECK(overlapping > 0);
  // One box fills all slabs, and what lies beyond them is visited.
  if (boxes.size() > 100) CHECK(visited <= 3 * overlapping);
}

}  // namespace

TEST_CASE("sets of boxes by slabs: all that overlap are among those visited, wherever they have moved") {
  Random random(1);
  for (const std::size_t n : {std::size_t{1}, std::size_t{63}, std::size_t{64}, std::size_t{300}, IntervalBits::most}) {
    BoxArray boxes, asked;
    boxes.resize(n), asked.resize(200);
    for (std::size_t i = 0; i < n; ++i) boxes.set(i, random_box(random, 5, 1));
    // Some beyond all slabs.
    for (std::size_t q = 0; q < asked.size(); ++q) asked.set(q, random_box(random, q % 10 == 0 ? 20 : 5, 4));
    asked.set(0, {{-1e30f, -1e30f, -1e30f}, {1e30f, 1e30f, 1e30f}});
    IntervalBits bits;
    bits.build(boxes);
    REQUIRE(bits.is_built());
    compare(bits, boxes, asked);
    for (std::uint32_t i = 0; i < n; i += 2) {
      boxes.set(i, random_box(random, 5, 2));
      bits.move(i, boxes[i]);
    }
    compare(bits, boxes, asked);
  }
}

TEST_CASE("sets of boxes by slabs: empty boxes are in none, and come and go") {
  BoxArray boxes;
  boxes.resize(3);
  boxes.set(0, {{0, 0, 0}, {1, 1, 1}}), boxes.set_empty(1), boxes.set(2, {{2, 2, 2}, {3, 3, 3}});
  IntervalBits bits;
  bits.build(boxes);
  constexpr float inf = std::numeric_limits<float>::infinity();
  const IntervalBits::Ends all = bits.ends_of({{-inf, -inf, -inf}, {inf, inf, inf}});
  CHECK(near(bits, all) == std::vector<std::uint32_t>{0, 2});
  CHECK(near(bits, bits.ends_of({{2.5f, 2.5f, 2.5f}, {2.6f, 2.6f, 2.6f}})) == std::vector<std::uint32_t>{2});
  boxes.set_empty(0), bits.move(0, boxes[0]);
  boxes.set(1, {{0, 0, 0}, {3, 3, 3}}), bits.move(1, boxes[1]);
  CHECK(near(bits, all) == std::vector<std::uint32_t>{1, 2});
  CHECK(near(bits, bits.ends_of({{0, 0, 0}, {0, 0, 0}})) == std::vector<std::uint32_t>{1});
}

TEST_CASE("sets of boxes by slabs: where an axis has no extent, or no finite one, all are visited") {
  BoxArray boxes;
  boxes.resize(2);
  constexpr float most = std::numeric_limits<float>::max();
  boxes.set(0, {{-most, 1, 0}, {-most, 1, 1}}), boxes.set(1, {{most, 1, 0}, {most, 1, 1}});
  IntervalBits bits;
  bits.build(boxes);
  CHECK(near(bits, bits.ends_of({{-most, 1, 0}, {most, 1, 1}})) == std::vector<std::uint32_t>{0, 1});
  CHECK(near(bits, bits.ends_of({{-most, 1, 0.5f}, {-most, 1, 0.5f}})) == std::vector<std::uint32_t>{0, 1});
}

TEST_CASE("configurations: among more bodies than fit in sets of bits the same answers") {
  Random random(2);
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{0.1});
  for (std::size_t i = 0; i < IntervalBits::most + 100; ++i)
    scene.add_body({.shape = ball, .pose = {random.rotation(), random.vec(-2, 2)}, .is_static = true});
  const std::vector<Shape> links{Box{{0.1, 0.2, 0.3}}, Capsule{0.05, 0.4}};
  std::vector<Pose> poses;
  for (int i = 0; i < 300; ++i) poses.push_back({random.rotation(), random.vec(-2, 2)});
  const SceneQueries queries(scene);
  std::vector<Verdict> verdicts(150);
  std::vector<FirstHit> hits(150);
  queries.check(links, poses, PairTable(), verdicts);
  queries.first_hits(links, poses, PairTable(), hits);
  std::size_t free = 0;
  for (std::size_t i = 0; i < 150; ++i) {
    const bool hit = queries.collides(links[0], poses[2 * i]) || queries.collides(links[1], poses[2 * i + 1]);
    REQUIRE(verdicts[i] == (hit ? Verdict::hit : Verdict::free));
    REQUIRE(hits[i].verdict == verdicts[i]);
    free += hit ? 0 : 1;
  }
  CHECK(free > 10);
  CHECK(free < 140);
}

TEST_CASE("sets of boxes by slabs: not built where a large box takes all slabs") {
  Random random(6);
  BoxArray boxes;
  boxes.resize(300);
  for (std::size_t i = 0; i < 300; ++i) boxes.set(i, random_box(random, 1, 0.1));
  IntervalBits bits;
  bits.build(boxes);
  CHECK(bits.is_built());
  boxes.set(0, {{-50, -50, -50}, {50, 50, 50}});
  bits.build(boxes);
  CHECK_FALSE(bits.is_built());
}
