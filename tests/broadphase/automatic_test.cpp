// The automatic choice of the broad phase.
#include "box_worlds.h"
#include "catch.h"

using namespace tandem;

namespace {

const BoxArray& boxes_of(const std::vector<BoxWorld>& worlds, std::string_view name) {
  return std::find_if(worlds.begin(), worlds.end(), [&](const BoxWorld& w) { return w.name == name; })->boxes;
}

}  // namespace

TEST_CASE("automatic: the pairs of brute force whatever it chooses") {
  const auto method = make_broad_phase(BroadPhaseKind::automatic);
  for (const std::size_t n : {0u, 1u, 2u, 9u, 255u, 256u, 1023u, 1024u, 3000u, 64u})
    for (const BoxWorld& world : hard_worlds(n)) {
      CAPTURE(world.name, n);
      CHECK(find_pairs(*method, world.boxes) == overlapping_pairs(world.boxes));
      CHECK_FALSE(method->reason().empty());
    }
}

TEST_CASE("automatic: chooses by number, then by what the grid met, and says so") {
  const auto method = make_broad_phase(BroadPhaseKind::automatic);
  const auto kind_for = [&](const BoxArray& boxes) {
    (void)find_pairs(*method, boxes);
    return method->kind();
  };
  CHECK(kind_for(hard_worlds(100)[0].boxes) == BroadPhaseKind::brute);
  CHECK(method->reason() == "brute: 100 boxes, fewer than 256");
  CHECK(kind_for(hard_worlds(500)[0].boxes) == BroadPhaseKind::sweep);

  const auto worlds = hard_worlds(20000);
  const BoxArray& even = boxes_of(worlds, "random");
  const BoxArray& clusters = boxes_of(worlds, "two tight clusters, far apart");
  for (int step = 0; step < 3; ++step) CHECK(kind_for(even) == BroadPhaseKind::grid);
  CHECK(kind_for(clusters) == BroadPhaseKind::grid);  // the boxes of a step are seen only when it runs
  CHECK(kind_for(clusters) == BroadPhaseKind::bvh);
  CHECK(method->reason().substr(0, 20) == "bvh: boxes cluster, ");

  // A world that has become uniform again gets its grid back, in a bounded number of steps.
  int steps = 0;
  while (kind_for(even) != BroadPhaseKind::grid && steps < 100) ++steps;
  CHECK(steps < 100);
  CHECK(kind_for(even) == BroadPhaseKind::grid);
}

TEST_CASE("automatic: a crowd and a small world in turn do not carry over") {
  const auto method = make_broad_phase(BroadPhaseKind::automatic);
  const auto crowd = hard_worlds(20000), few = hard_worlds(64);
  const BoxArray& clusters = boxes_of(crowd, "two tight clusters, far apart");
  for (int turn = 0; turn < 3; ++turn) {
    CHECK(find_pairs(*method, clusters).size() > 1000);
    CHECK(find_pairs(*method, few[0].boxes) == overlapping_pairs(few[0].boxes));
    CHECK(method->kind() == BroadPhaseKind::brute);
  }
}

TEST_CASE("automatic: memory does not grow in 10,000 steps of a changing scene") {
  // Boxes appear, leave, jump and cluster in turn; memory is at its largest in the first rounds.
  constexpr std::size_t n = 1100;
  BoxArray boxes = hard_worlds(n)[0].boxes;
  const auto method = make_broad_phase(BroadPhaseKind::automatic);
  Random random(6);
  std::size_t early = 0, pairs = 0;
  for (int step = 0; step < 10'000; ++step) {
    const float side = step % 400 < 300 ? 21.0f : 9.0f;
    for (int k = 0; k < 12; ++k) {
      const std::size_t i = random() % n;
      const Point at{uniform(random, 0, side), uniform(random, 0, side), uniform(random, 0, side)};
      if (random() % 4 == 0)
        boxes.set_empty(i);
      else
        boxes.set(i, {at, {at[0] + 1, at[1] + 1, at[2] + 1}});
    }
    if (step % 400 == 399) boxes = hard_worlds(n)[0].boxes;
    pairs += find_pairs(*method, boxes).size();
    if (step == 4000) early = method->memory();
  }
  CHECK(pairs > 1'000'000);
  CHECK(early > n * sizeof(Aabb));
  CHECK(method->memory() < early + early / 10);
  CHECK(method->memory() < 4000 * n);
}
