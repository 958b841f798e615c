// Triangles in lanes.
#include "triangles/triangle_rows.h"

#include <Eigen/Geometry>
#include <algorithm>
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

/// Compares the verdicts on pairs, in groups of all sizes, with exact arithmetic.
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
  std::uniform_int_distribution<int> cells(-1, 1);
  const auto cell = [&]() -> double { return cells(random); };
  const auto corner = [&] { return Vec3{cell(), cell(), cell()}; };
  const Counts flat = count_verdicts({}, {}, 1, corner);
  CHECK(flat.unknown > 20);
  reference::Random poses(3);
  for (int i = 0; i < 20; ++i) {
    const Pose pose{poses.rotation(), poses.vec(-1e3, 1e3)};
    CHECK(count_verdicts(pose, pose, 1, corner).unknown > 20);
    // Barely apart.
    const Vec3 hair = 1e-13 * poses.vec(-1, 1);
    count_verdicts(pose, {pose.rotation, pose.translation + hair}, 1, corner);
  }
}

TEST_CASE("crossings several at a time: both ends lie on an edge of one triangle and in the other, along the curve") {
  reference::Random random(9);
  int crossings = 0;
  for (int i = 0; i < 400; ++i) {
    const Pose pose_a{random.rotation(), random.vec(-1, 1)}, pose_b{random.rotation(), pose_a.translation};
    TriangleTest test(pose_a, pose_b, 1);
    TriangleRows rows{};
    std::vector<std::array<std::array<Vec3, 3>, 2>> pairs(1 + static_cast<std::size_t>(i) % TriangleRows::most);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      for (auto& t : pairs[k])
        for (Vec3& v : t) v = random.vec(-1, 1);
      rows.set(k, pairs[k][0], pairs[k][1]);
    }
    CrossingRows found;
    cross_triangles(rows, pairs.size(), test, found);
    CHECK(found.crosses >> pairs.size() == 0);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (!test.exact(pairs[k][0], pairs[k][1])) continue;
      ++crossings;
      REQUIRE((found.crosses >> k & 1u) != 0);
      const auto& a = pairs[k][0];
      std::array<Vec3, 3> b = pairs[k][1];
      for (Vec3& v : b) v = test.in_a(v);
      const Vec3 normal_a = (a[1] - a[0]).cross(a[2] - a[0]), normal_b = (b[1] - b[0]).cross(b[2] - b[0]);
      std::array<Vec3, 2> ends;
      for (std::size_t e = 0; e < 2; ++e) {
        const CrossingRows::End& end = found.end[e];
        ends[e] = {end.point[0][k], end.point[1][k], end.point[2][k]};
        const bool of_a = end.edge[k] < 3;
        const auto corner = static_cast<std::size_t>(end.edge[k]) % 3;
        const auto &own = of_a ? a : b, &other = of_a ? b : a;
        const Vec3 normal = of_a ? normal_b : normal_a, from = own[corner], to = own[(corner + 1) % 3];
        CHECK((end.part[k] >= 0 && end.part[k] <= 1));
        CHECK((from + end.part[k] * (to - from) - ends[e]).norm() < 1e-14);
        CHECK(std::abs(normal.dot(ends[e] - other[0])) < 1e-13);
        for (std::size_t c = 0; c < 3; ++c)
          CHECK(normal.dot((other[(c + 1) % 3] - other[c]).cross(ends[e] - other[c])) > -1e-12);
        CHECK(((end.from_inside >> k & 1u) != 0) == (normal.dot(from - other[0]) < 0));
      }
      CHECK(normal_a.cross(normal_b).dot(ends[1] - ends[0]) >= 0);
    }
  }
  CHECK(crossings > 200);
}

TEST_CASE("farthest of points along several directions: the first of equals") {
  reference::Random random(4);
  for (std::size_t count = 1; count < 40; ++count) {
    std::vector<double> points;
    for (std::size_t i = 0; i < 4 * count; ++i) points.push_back(random.below(3));  // the fourth number is not read
    DirectionRows rows{};
    for (std::size_t k = 0; k < 9; ++k)
      for (auto& axis : rows.direction) axis[k] = random.below(5) - 2;
    const std::size_t some = std::min<std::size_t>(count, 7);
    find_farthest(rows, 9, points.data(), 4, 0, some);
    find_farthest(rows, 9, points.data(), 4, some, count);
    for (std::size_t k = 0; k < 9; ++k) {
      std::vector<double> along;
      for (std::size_t i = 0; i < count; ++i) {
        along.push_back(0);
        for (std::size_t axis = 0; axis < 3; ++axis) along.back() += rows.direction[axis][k] * points[4 * i + axis];
      }
      CHECK(rows.best[k] == static_cast<double>(std::max_element(along.begin(), along.end()) - along.begin()));
    }
  }
}
