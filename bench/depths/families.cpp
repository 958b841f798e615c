// Families of solid meshes by formula, placed deep in each other.
#include "depths/families.h"

#include <cmath>
#include <numbers>

#include "ball_triangles.h"

namespace tandem::bench {
namespace {

using reference::Random;
constexpr double turn = 2 * std::numbers::pi;

// A closed grid of points point(u, v), u and v in [0, 1), periodic in both.
template <class Point>
Mesh closed_grid(int around, int along, Point&& point) {
  Mesh mesh;
  mesh.solid = true;
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i % around * along + j % along); };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < along; ++j) {
      mesh.vertices.push_back(point(i, j));
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

// A point of a profile, in the plane of radius and height, turned about z.
Vec3 turned(double angle, double radius, double height) {
  return {radius * std::cos(angle), radius * std::sin(angle), height};
}

Mesh torus(double ring, double tube) {
  return closed_grid(32, 16, [=](int i, int j) {
    const double v = turn * j / 16;
    return turned(turn * i / 32, ring + tube * std::cos(v), tube * std::sin(v));
  });
}

// A ring with a rectangular profile.
Mesh ring_mesh(double inner, double outer, double height) {
  return closed_grid(48, 4, [=](int i, int j) {
    return turned(turn * i / 48, j < 2 ? outer : inner, (j == 1 || j == 2 ? 0.5 : -0.5) * height);
  });
}

Mesh gear(int teeth, double bore, double height) {
  return closed_grid(4 * teeth, 4, [=](int i, int j) {
    const double outer = i % 4 < 2 ? 1 : 0.8;
    return turned(turn * (i + (i % 2 == 0 ? 0.15 : -0.15)) / (4 * teeth), j < 2 ? outer : bore,
                  (j == 1 || j == 2 ? 0.5 : -0.5) * height);
  });
}

// A ball's triangles with the vertices point(j, i), j rows from pole to pole.
template <class Point>
Mesh ball_grid(int turns, int rings, Point&& point) {
  Mesh mesh;
  mesh.solid = true;
  mesh.vertices.push_back(point(0, 0));
  for (int j = 1; j < rings; ++j)
    for (int i = 0; i < turns; ++i) mesh.vertices.push_back(point(j, i));
  mesh.vertices.push_back(point(rings, 0));
  add_ball_triangles(mesh, turns, rings);
  return mesh;
}

// A bowl that is open upwards: the outside of a sphere of radius 1 and the inside of one of radius 1 - wall.
Mesh bowl(double wall) {
  constexpr int rows = 8;
  return ball_grid(32, 2 * rows + 1, [=](int j, int i) {
    const bool outside = j <= rows;
    const double v = 1.45 * (outside ? j : 2 * rows + 1 - j) / rows, radius = outside ? 1 : 1 - wall;
    return turned(turn * i / 32, radius * std::sin(v), -radius * std::cos(v));
  });
}

Mesh blob(double phase) {
  return ball_grid(32, 16, [=](int j, int i) {
    const double u = turn * i / 32, v = std::numbers::pi * j / 16;
    const Vec3 d(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), -std::cos(v));
    return Vec3((1 + 0.15 * std::sin(4 * d.x() + phase) * std::sin(5 * d.y()) * std::cos(3 * d.z() - phase)) * d);
  });
}

// Two meshes in random rotations, their centres less than `reach` apart.
DeepPair placed(Mesh a, Mesh b, double reach, Random& random) {
  const Pose pose_a = Pose::from(random.quaternion(), random.vec(-1, 1));
  const Pose pose_b = Pose::from(random.quaternion(), pose_a.translation + random.in(0, reach) * random.direction());
  return {Shape(std::move(a)), Shape(std::move(b)), pose_a, pose_b};
}

DeepPair bowls(Random& r) { return placed(bowl(r.in(0.1, 0.3)), bowl(r.in(0.1, 0.3)), 0.9, r); }
DeepPair rings(Random& r) {
  return placed(ring_mesh(r.in(0.4, 0.8), 1, r.in(0.2, 0.6)), ring_mesh(r.in(0.4, 0.8), 1, r.in(0.2, 0.6)), 1, r);
}
DeepPair gears(Random& r) {
  return placed(gear(6 + r.below(7), r.in(0.2, 0.5), r.in(0.2, 0.5)),
                gear(6 + r.below(7), r.in(0.2, 0.5), r.in(0.2, 0.5)), 1, r);
}
DeepPair tori(Random& r) { return placed(torus(0.7, r.in(0.15, 0.3)), torus(0.7, r.in(0.15, 0.3)), 1, r); }
DeepPair blobs(Random& r) { return placed(blob(r.in(0, turn)), blob(r.in(0, turn)), 1, r); }

}  // namespace

std::vector<DepthFamily> depth_families() {
  return {{"bowls", bowls}, {"rings", rings}, {"gears", gears}, {"tori", tori}, {"blobs", blobs}};
}

}  // namespace tandem::bench
