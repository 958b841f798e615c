// Meshes by formula and scenes of all kinds of shapes.
#include "round_meshes/meshes.h"

#include <cmath>
#include <numbers>

#include "ball_triangles.h"
#include "engine/scene/mesh_generators.h"
#include "reference/random.h"

namespace tandem::bench {
namespace {

using reference::Random;

/// A ball of this radius with hills and hollows: 2 * turns * (rings - 1) triangles.
Mesh bumpy_ball(double radius, int turns, int rings) {
  Mesh mesh;
  mesh.solid = true;
  const auto add = [&](const Vec3& d) {
    const double bump = std::sin(7 * d.x()) * std::sin(6 * d.y() + 1) * std::sin(5 * d.z() + 2);
    mesh.vertices.emplace_back(radius * (0.94 + 0.06 * bump) * d);
  };
  add({0, 0, -1});
  for (int j = 1; j < rings; ++j)
    for (int i = 0; i < turns; ++i) {
      const double u = 2 * std::numbers::pi * i / turns, v = std::numbers::pi * j / rings;
      add({std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), -std::cos(v)});
    }
  add({0, 0, 1});
  add_ball_triangles(mesh, turns, rings);
  return mesh;
}

/// Hills over a square, 2 * cells^2 triangles, open.
Mesh hilly_sheet(double half_width, int cells) {
  Mesh mesh;
  for (int j = 0; j <= cells; ++j)
    for (int i = 0; i <= cells; ++i) {
      const double x = 2.0 * i / cells - 1, y = 2.0 * j / cells - 1;
      mesh.vertices.emplace_back(half_width * Vec3(x, y, 0.08 * std::sin(6 * x + 1) * std::cos(5 * y)));
    }
  const auto at = [cells](int j, int i) { return static_cast<std::uint32_t>(j * (cells + 1) + i); };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i) {
      mesh.triangles.push_back({at(j, i), at(j, i + 1), at(j + 1, i + 1)});
      mesh.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j + 1, i)});
    }
  return mesh;
}

Mesh bolt(double radius, int segments) {
  const Thread thread{.root_radius = 0.24 * radius, .crest_radius = 0.3 * radius, .pitch = 0.2 * radius, .turns = 6};
  return make_bolt({.thread = thread, .head_radius = 0.45 * radius, .head_height = 0.3 * radius, .segments = segments});
}

/// The kinds of the mixed scene, in turn.
std::vector<NamedShape> mixed_kinds() {
  std::vector<NamedShape> all;
  const std::vector<NamedShape> convex = convex_shapes(0.5);
  std::vector<NamedShape> meshes;
  meshes.push_back({"bumpy ball", Shape(bumpy_ball(0.5, 60, 40))});
  meshes.push_back({"torus", Shape(make_torus(0.35, 0.15, 40, 30))});
  meshes.push_back({"bolt", Shape(bolt(0.6, 24))});
  for (const NamedShape& mesh : meshes) {
    all.insert(all.end(), convex.begin(), convex.end());
    all.push_back(mesh);
  }
  return all;
}

Scene with_kinds(std::vector<ShapeId>& ids) {
  Scene scene;
  for (NamedShape& kind : mixed_kinds()) ids.push_back(scene.add_shape(std::move(kind.shape), kind.name));
  return scene;
}

}  // namespace

std::vector<NamedShape> large_meshes() {
  std::vector<NamedShape> all;
  all.push_back({"bumpy ball", Shape(bumpy_ball(1, 76, 40))});
  all.push_back({"torus", Shape(make_torus(0.7, 0.3, 75, 40))});
  all.push_back({"bolt", Shape(bolt(1, 60))});
  all.push_back({"sheet", Shape(hilly_sheet(0.7, 55))});
  return all;
}

std::vector<NamedShape> convex_shapes(double r) {
  Random random(5);
  Convex hull;
  for (int i = 0; i < 32; ++i) hull.vertices.emplace_back(r * random.in(0.85, 1) * random.direction());
  std::vector<NamedShape> all;
  all.push_back({"sphere", Shape(Sphere{r})});
  all.push_back({"capsule", Shape(Capsule{0.6 * r, 0.8 * r})});
  all.push_back({"box", Shape(Box{{1.4 * r, 1.1 * r, 0.9 * r}})});
  all.push_back({"cylinder", Shape(Cylinder{0.75 * r, 1.3 * r})});
  all.push_back({"cone", Shape(Cone{0.8 * r, 1.4 * r})});
  all.push_back({"ellipsoid", Shape(Ellipsoid{{r, 0.8 * r, 0.55 * r}})});
  all.push_back({"hull", Shape(hull)});
  return all;
}

Scene mixed_scene(std::size_t bodies) {
  std::vector<ShapeId> ids;
  Scene scene = with_kinds(ids);
  Random random(9);
  const double half_width = 0.5 * std::cbrt(static_cast<double>(bodies) / 1.4);  // bodies a cubic metre
  for (std::size_t i = 0; i < bodies; ++i) {
    BodyOptions body;
    body.shape = ids[i % ids.size()];
    body.pose = {random.rotation(), random.vec(-half_width, half_width)};
    scene.add_body(body);
  }
  return scene;
}

Scene falling_mixed_scene(std::size_t bodies) {
  std::vector<ShapeId> ids;
  Scene scene = with_kinds(ids);
  Random random(9);
  BodyOptions floor;
  floor.shape = scene.add_shape(Shape(HalfSpace{Vec3::UnitZ(), 0}), "floor");
  floor.is_static = true;
  scene.add_body(floor);
  constexpr std::size_t layers = 4;
  constexpr double room = 1.3;  // metres
  const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(bodies) / layers)));
  for (std::size_t i = 0; i < bodies; ++i) {
    const std::size_t x = i % side, y = i / side % side, z = i / (side * side);
    BodyOptions body;
    body.shape = ids[(i * 7 + z) % ids.size()];  // so that no column or row is of one kind
    body.pose.rotation = random.rotation();
    body.pose.translation =
        room * Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z) + 0.5) + random.vec(0, 0.1);
    scene.add_body(body);
  }
  return scene;
}

}  // namespace tandem::bench
