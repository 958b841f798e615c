// Point clouds, height fields and voxels.
#include "tandem/narrowphase/shape_makers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.h"
#include "random_pairs.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("a point cloud is its balls") {
  Random r(3);
  std::vector<Vec3> points;
  for (int i = 0; i < 300; ++i) points.push_back(r.vec(-1, 1));
  const NarrowPhase n;
  for (const double radius : {0.0, 0.05}) {
    const Shape cloud = point_cloud(points, radius);
    CHECK(cloud.triangles().size() == points.size());
    for (int i = 0; i < 200; ++i) {
      const Shape ball = Sphere{r.in(0.01, 0.3)}, box = Box{r.vec(0.05, 0.4)};
      const Pose at = random_pose(r, 1.3), own = random_pose(r, 0.5);
      double of_ball = std::numeric_limits<double>::infinity(), of_box = of_ball;
      for (const Vec3& p : points) {
        const Pose there{Mat3::Identity(), own * p};
        of_ball = std::min(of_ball, n.solve(Sphere{radius}, there, ball, at, Request::distance).signed_distance);
        of_box = std::min(of_box, n.solve(Sphere{radius}, there, box, at, Request::distance).signed_distance);
      }
      CAPTURE(i, radius, of_ball, of_box);
      CHECK(n.solve(cloud, own, ball, at, Request::collide).collide == (of_ball <= 0));
      CHECK(n.solve(cloud, own, box, at, Request::collide).collide == (of_box <= 0));
      if (of_ball > 0)
        CHECK(std::abs(n.solve(cloud, own, ball, at, Request::distance).signed_distance - of_ball) < 1e-13);
      if (of_box > 0) CHECK(std::abs(n.solve(cloud, own, box, at, Request::distance).signed_distance - of_box) < 1e-13);
    }
  }
  CHECK_THROWS_AS(point_cloud({}, 0), std::invalid_argument);
  CHECK_THROWS_AS(point_cloud(points, -1), std::invalid_argument);
}

TEST_CASE("a height field is solid land: volume, points above and below, refusals") {
  const std::vector<double> flat(6, 2.0), hill{0, 0, 0, 0, 1, 0, 0, 0, 0};
  const Shape slab = height_field(flat, 3, 2, 0.5, 1.5);
  CHECK(slab.is_solid());
  CHECK(std::abs(slab.mass().volume - 1.0 * 0.5 * 0.5) < 1e-14);
  const Shape land = height_field(hill, 3, 3, 1, -1);
  const NarrowPhase n;
  const auto distance = [&](double x, double y, double z) {
    return n.solve(Sphere{0}, Pose::at(x, y, z), land, Pose{}, Request::distance).signed_distance;
  };
  CHECK(std::abs(distance(0, 0, 1.5) - 0.5) < 1e-14);
  CHECK(n.solve(Sphere{0}, Pose::at(0, 0, 0.99), land, Pose{}, Request::collide).collide);
  CHECK_FALSE(n.solve(Sphere{0}, Pose::at(0.9, 0, 0.2), land, Pose{}, Request::collide).collide);
  CHECK(n.solve(Sphere{0}, Pose::at(0.9, 0, -0.9), land, Pose{}, Request::collide).collide);
  CHECK(distance(0, 0, -2) == 1);
  CHECK_THROWS_AS(height_field(hill, 3, 2, 1, -1), std::invalid_argument);
  CHECK_THROWS_AS(height_field(hill, 9, 1, 1, -1), std::invalid_argument);
  CHECK_THROWS_AS(height_field(hill, 3, 3, 0, -1), std::invalid_argument);
  CHECK_THROWS_AS(height_field(hill, 3, 3, 1, 0), std::invalid_argument);
}

TEST_CASE("a mesh of voxels is the union of their cells: verdicts, distances, volume, refusals") {
  Random r(5);
  const NarrowPhase n;
  for (const int count : {1, 12, 90}) {
    std::vector<std::array<std::int32_t, 3>> cells;
    for (int i = 0; i < count; ++i)
      cells.push_back({static_cast<std::int32_t>(r.in(-3, 3)), static_cast<std::int32_t>(r.in(-3, 3)),
                       static_cast<std::int32_t>(r.in(-3, 3))});
    std::vector<std::array<std::int32_t, 3>> once = cells;
    std::sort(once.begin(), once.end());
    once.erase(std::unique(once.begin(), once.end()), once.end());
    const double size = 0.3;
    const Shape solid = voxel_mesh(cells, size);
    CHECK(solid.is_solid());
    CHECK(std::abs(solid.mass().volume - size * size * size * static_cast<double>(once.size())) < 1e-12);
    std::reverse(cells.begin(), cells.end());
    CHECK(voxel_mesh(cells, size).triangles().size() == solid.triangles().size());
    int hits = 0;
    for (int i = 0; i < 300; ++i) {
      const Shape ball = Sphere{r.in(0.01, 0.3)}, box = Box{r.vec(0.05, 0.4)};
      const Pose at = random_pose(r, 1.5), own = random_pose(r, 0.3);
      for (const Shape* other : {&ball, &box}) {
        double least = std::numeric_limits<double>::infinity();
        for (const auto& cell : once) {
          const Vec3 centre = size * (Vec3(cell[0], cell[1], cell[2]) + Vec3::Constant(0.5));
          const Pose there{own.rotation, own * centre};
          const Shape cube = Box{Vec3::Constant(size)};
          least = std::min(least, n.solve(cube, there, *other, at, Request::distance).signed_distance);
        }
        CAPTURE(count, i, least);
        CHECK(n.solve(solid, own, *other, at, Request::collide).collide == (least <= 0));
        if (least > 0)
          CHECK(std::abs(n.solve(solid, own, *other, at, Request::distance).signed_distance - least) < 1e-12);
        hits += least <= 0;
      }
    }
    CHECK(hits > 5);
  }
  const std::vector<std::array<std::int32_t, 3>> apart{
      {0, 0, 0}, {1, 1, 0}, {1, 1, 1}, {2, 2, 2}};  // edges and corners
  CHECK(voxel_mesh(apart, 1).triangles().size() == 2 * (6 + 10 + 6));
  CHECK_THROWS_AS(voxel_mesh({}, 1), std::invalid_argument);
  CHECK_THROWS_AS(voxel_mesh(apart, 0), std::invalid_argument);
  const std::vector<std::array<std::int32_t, 3>> far{{1 << 20, 0, 0}};
  CHECK_THROWS_AS(voxel_mesh(far, 1), std::invalid_argument);
}
