#include "triangles/triangle_rows.h"

#include <random>
#include <vector>

#include "catch.h"
#include "random.h"
#include "triangles/predicates.h"

using namespace tandem;

namespace {

using Corners = std::array<Vec3, 3>;

struct Counts {
  int meet = 0, apart = 0, unknown = 0;
};

/// Compares what is said of some pairs, in groups of all sizes, with exact arithmetic.
template <class Corner>
Counts count_verdicts(const Pose& pose_a, const Pose& pose_b, double reach, Corner&& corner) {
  TriangleTest test(pose_a, pose_b, reach);
  Counts counts;
  TriangleRows rows{};
  for (std::size_t group = 0; group < 40; ++group) {
    const std::size_t size = 1 + group % TriangleRows::most;
    std::vector<std::array<Corners, 2>> pairs(size);
    for (std::size_t k = 0; k < size; ++k) {
      for (Corners& t : pairs[k])
        for (Vec3& v : t) v = corner();
      rows.set(k, pairs[k][0], pairs[k][1]);
    }
    const TriangleVerdicts verdicts = compare_triangles(rows, size, test);
    CHECK((verdicts.meet & verdicts.unknown) == 0);
    CHECK((verdicts.meet | verdicts.unknown) >> size == 0);
    for (std::size_t k = 0; k < size; ++k) {
      const bool unknown = (verdicts.unknown >> k & 1u) != 0, meet = (verdicts.meet >> k & 1u) != 0;
      ++(unknown ? counts.unknown : meet ? counts.meet : counts.apart);
      if (!unknown) CHECK(meet == test.exact(pairs[k][0], pairs[k][1]));
    }
  }
  return counts;
}

}  // namespace

TEST_CASE("triangles several at a time: what is said of them is so, and of most in any pose something is said") {
  reference::Random random(7);
  Counts all;
  for (int i = 0; i < 40; ++i) {
    const Pose pose_a{random.rotation(), random.vec(-0.2, 0.2)}, pose_b{random.rotation(), random.vec(-0.2, 0.2)};
    const Counts some = count_verdicts(pose_a, pose_b, 1, [&] { return random.vec(-1, 1); });
    all.meet += some.meet, all.apart += some.apart, all.unknown += some.unknown;
  }
  CHECK(all.meet > 500);
  CHECK(all.apart > 500);
  CHECK(all.unknown < 10);
}

TEST_CASE("triangles several at a time: touching, coplanar and zero-area ones are left unknown or told right") {
  std::mt19937_64 random(5);
  std::uniform_int_distribution<int> cell(-1, 1);
  const auto corner = [&] { return Vec3(cell(random), cell(random), cell(random)); };
  const Counts flat = count_verdicts({}, {}, 1, corner);
  CHECK(flat.unknown > 20);
  reference::Random poses(3);
  for (int i = 0; i < 20; ++i) {
    const Pose pose{poses.rotation(), poses.vec(-1e3, 1e3)};
    CHECK(count_verdicts(pose, pose, 1, corner).unknown > 20);
    // A hair apart.
    const Vec3 hair = 1e-13 * poses.vec(-1, 1);
    count_verdicts(pose, {pose.rotation, pose.translation + hair}, 1, corner);
  }
}
