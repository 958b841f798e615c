// The worlds of the planner bench: robot arms and obstacles.
#include "planner/planner_world.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "random.h"

namespace tandem::bench {
namespace {

using reference::Random;

constexpr int joints = 7;
/// Metres: about those of a lightweight arm that reaches 1.2 m.
constexpr std::array<double, joints> lengths{0.2, 0.2, 0.22, 0.2, 0.2, 0.12, 0.1};
constexpr double link_radius = 0.05;

/// Points on a capsule, as a hull.
Convex rounded_prism(double radius, double length) {
  Convex hull;
  constexpr int sides = 8;
  for (const double end : {-1.0, 1.0})
    for (int k = 0; k < sides; ++k) {
      const double angle = 2 * std::numbers::pi * k / sides;
      hull.vertices.push_back({radius * std::cos(angle), radius * std::sin(angle), end * length / 2});
      hull.vertices.push_back(
          {0.6 * radius * std::cos(angle), 0.6 * radius * std::sin(angle), end * (length / 2 + 0.8 * radius)});
    }
  return hull;
}

/// A tube with closed ends, `rings` rings of 16 corners.
Mesh tube(double radius, double length, int rings) {
  Mesh mesh;
  mesh.solid = true;
  constexpr std::uint32_t sides = 16;
  for (int ring = 0; ring < rings; ++ring)
    for (std::uint32_t k = 0; k < sides; ++k) {
      const double angle = 2 * std::numbers::pi * k / sides;
      const double wave = radius * (1 + 0.1 * std::cos(5.0 * ring));
      mesh.vertices.push_back({wave * std::cos(angle), wave * std::sin(angle), length * (ring / (rings - 1.0) - 0.5)});
    }
  const auto bottom = static_cast<std::uint32_t>(mesh.vertices.size()), top = bottom + 1;
  mesh.vertices.push_back({0, 0, -length / 2 - radius / 2});
  mesh.vertices.push_back({0, 0, length / 2 + radius / 2});
  for (std::uint32_t k = 0; k < sides; ++k) {
    const std::uint32_t next = (k + 1) % sides, last = static_cast<std::uint32_t>(rings - 1) * sides;
    mesh.triangles.push_back({bottom, next, k});
    mesh.triangles.push_back({top, last + k, last + next});
    for (std::uint32_t ring = 0; ring + 1 < static_cast<std::uint32_t>(rings); ++ring) {
      const std::uint32_t a = ring * sides + k, b = ring * sides + next;
      mesh.triangles.push_back({a, b, b + sides});
      mesh.triangles.push_back({a, b + sides, a + sides});
    }
  }
  return mesh;
}

Shape link(LinkKind kind, double length) {
  switch (kind) {
    case LinkKind::capsules:
      return Capsule{link_radius, length};
    case LinkKind::hulls:
      return Shape(rounded_prism(link_radius, length));
    default:
      return Shape(tube(link_radius, length, 12));
  }
}

Shape obstacle(int i, double size, Random& random) {
  switch (i % 4) {
    case 0:
      return Box{size * random.vec(0.5, 1.5)};
    case 1:
      return Cylinder{size * random.in(0.3, 0.6), size * random.in(0.5, 2)};
    case 2: {
      Convex hull;
      for (int k = 0; k < 16; ++k) hull.vertices.push_back(0.6 * size * random.direction());
      return Shape(hull);
    }
    default:
      return Shape(tube(0.4 * size, size, 3));
  }
}

/// The links' poses at these angles, each about z or y in turn.
void place(const Pose& base, const std::array<double, joints>& angles, std::vector<Pose>& out) {
  Pose at = base;
  for (std::size_t j = 0; j < joints; ++j) {
    const Vec3 axis = j % 2 == 0 ? Vec3::UnitZ() : Vec3::UnitY();
    at.rotation = at.rotation * Eigen::AngleAxisd(angles[j], axis).toRotationMatrix();
    const Vec3 along = at.rotation.col(2) * lengths[j];
    out.push_back({at.rotation, at.translation + along / 2});
    at.translation += along;
  }
}

std::array<double, joints> random_angles(Random& random) {
  std::array<double, joints> angles;
  for (std::size_t j = 0; j < joints; ++j) angles[j] = random.in(-2.2, 2.2);
  return angles;
}

std::string_view name(LinkKind kind) {
  return kind == LinkKind::capsules ? "capsules" : kind == LinkKind::hulls ? "hulls" : "meshes";
}

}  // namespace

PlannerWorld planner_world(LinkKind kind, int arms, int obstacles, std::size_t configurations) {
  PlannerWorld world;
  world.name = fmt::format("{} arm{} of {}, {} obstacles", arms, arms > 1 ? "s" : "", name(kind), obstacles);
  Random random(7);
  std::vector<Pose> bases{Pose{}};
  const Mat3 half_turn = Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitZ()).toRotationMatrix();
  if (arms == 2) bases.push_back(Pose{half_turn, {0.9, 0, 0}});
  for (int arm = 0; arm < arms; ++arm)
    for (const double length : lengths) world.links.push_back(link(kind, length));
  const std::size_t links = world.links.size();
  world.self = PairTable(links, links, true);
  for (std::size_t i = 0; i < links; ++i)
    for (std::size_t j = i; j < links; ++j)
      if (i / joints == j / joints && j - i <= 2) world.self.set(i, j, false);

  const double size = obstacles > 100 ? 0.03 : 0.1;
  for (int i = 0; i < obstacles;) {
    const Vec3 place = random.vec(-1, 1) * (obstacles > 100 ? 1.3 : 0.9) + Vec3(arms == 2 ? 0.45 : 0, 0, 0);
    bool free = true;  // the bases stand free
    for (const Pose& base : bases)
      free = free && (place - base.translation - Vec3(0, 0, 0.15)).norm() > 0.3;
    if (!free) continue;
    world.obstacles.add_body({.shape = world.obstacles.add_shape(obstacle(i, size, random)),
                              .pose = {random.rotation(), place},
                              .is_static = true});
    ++i;
  }
  for (std::size_t i = 0; i < configurations; ++i)
    for (const Pose& base : bases) place(base, random_angles(random), world.random);
  for (std::size_t i = 0; i < configurations / PlannerWorld::a_motion; ++i) {
    std::vector<std::array<double, joints>> from, to;
    for (int arm = 0; arm < arms; ++arm) {
      from.push_back(random_angles(random));
      to.push_back(from.back());
      for (double& angle : to.back()) angle += random.in(-0.4, 0.4);
    }
    for (std::size_t k = 0; k < PlannerWorld::a_motion; ++k)
      for (std::size_t arm = 0; arm < bases.size(); ++arm) {
        std::array<double, joints> at;
        for (std::size_t j = 0; j < joints; ++j)
          at[j] = from[arm][j] + (to[arm][j] - from[arm][j]) * static_cast<double>(k) / (PlannerWorld::a_motion - 1);
        place(bases[arm], at, world.motions);
      }
  }
  return world;
}

}  // namespace tandem::bench
