// A capsule in a solid mesh lies in it, and shapes that intersect it collide.
#include "meshes/traversal/inner_capsule.h"

#include <array>
#include <cmath>
#include <numbers>

#include "catch.h"
#include "mesh_samples.h"
#include "meshes/traversal/point_in_mesh.h"
#include "random_pairs.h"
#include "shapes/shape_insides.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/prepare.h"

using namespace tandem;
using namespace tandem::test;

namespace {

/// A solid that every ray from its middle leaves once, and no more than that.
Mesh lump(Random& random, const Vec3& size) {
  constexpr std::uint32_t turns = 12, rings = 7;
  Mesh mesh;
  mesh.solid = true;
  for (std::uint32_t j = 0; j < rings; ++j)
    for (std::uint32_t i = 0; i < turns; ++i) {
      const double u = 2 * std::numbers::pi * i / turns, v = std::numbers::pi * (j + 1) / (rings + 1);
      const double r = random.in(0.6, 1);
      mesh.vertices.push_back(
          size.cwiseProduct(r * Vec3(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), -std::cos(v))));
    }
  const std::uint32_t bottom = turns * rings, top = bottom + 1;
  mesh.vertices.push_back(size.cwiseProduct(Vec3(0, 0, -1)));
  mesh.vertices.push_back(size.cwiseProduct(Vec3(0, 0, 1)));
  for (std::uint32_t i = 0; i < turns; ++i) {
    const std::uint32_t next = (i + 1) % turns, last = (rings - 1) * turns;
    mesh.triangles.push_back({bottom, next, i});
    mesh.triangles.push_back({top, last + i, last + next});
    for (std::uint32_t a = 0; a < last; a += turns) {
      mesh.triangles.push_back({a + i, a + next, a + turns + next});
      mesh.triangles.push_back({a + i, a + turns + next, a + turns + i});
    }
  }
  return mesh;
}

Mesh lump(Random& random) { return lump(random, {random.in(0.2, 2), random.in(0.2, 2), random.in(0.2, 2)}); }

}  // namespace

TEST_CASE("inner capsule: lies in the mesh, none where the middle does not or that is not solid") {
  Random random(3);
  int long_ones = 0;
  for (int round = 0; round < 20; ++round) {
    const Shape mesh(lump(random));
    make_inner_capsule(mesh, nullptr);
    const InnerCapsule& inner = *mesh_of(mesh).inner_capsule().made();
    REQUIRE(inner.radius > 0.05);
    long_ones += inner.half.norm() > 0;
    for (int k = 0; k < 100; ++k) {
      const Vec3 on_axis = inner.centre + random.in(-1, 1) * inner.half;
      const Vec3 p = on_axis + 0.999 * inner.radius * random.direction();
      REQUIRE(is_inside(mesh_of(mesh), p));
    }
  }
  CHECK(long_ones > 5);
  Mesh ring = torus(1, 0.3, 24, 12), surface = lump(random);
  ring.solid = true, surface.solid = false;
  for (const Shape& none : {Shape(ring), Shape(surface)}) {
    make_inner_capsule(none, nullptr);
    CHECK(mesh_of(none).inner_capsule().made()->radius == 0);
  }
}

TEST_CASE("inner capsule: what it says meets does, and a mesh that has none made says the same") {
  Random random(4);
  const NarrowPhase narrow;
  std::array<int, shape_kinds> told{}, meet{};
  for (int round = 0; round < 3000; ++round) {
    const auto kind =
        round % 2 == 0 ? ShapeKind::mesh : static_cast<ShapeKind>(static_cast<std::size_t>(round / 2) % shape_kinds);
    if (kind == ShapeKind::halfspace || kind == ShapeKind::plane || kind == ShapeKind::triangle ||
        kind == ShapeKind::voxels)  // these are never held against it
      continue;
    const Mesh solid = lump(random);
    const Shape plain(solid), prepared(solid);
    const Mesh other_solid = lump(random);
    const bool is_mesh = kind == ShapeKind::mesh;
    const Shape other = is_mesh ? Shape(other_solid) : random_shape(kind, random);
    const Shape other_plain = is_mesh ? Shape(other_solid) : other;
    prepare(prepared), prepare(other);
    const Pose a = random_pose(random, 1.5), b = random_pose(random, 1.5);
    CAPTURE(round, name(kind));
    const bool collide = narrow.solve(plain, a, other_plain, b, Request::collide).collide;
    const bool is_told = meets_inner_capsule({prepared, a}, {other, b});
    if (is_told) REQUIRE(collide);
    REQUIRE(narrow.solve(prepared, a, other, b, Request::collide).collide == collide);
    REQUIRE(narrow.solve(other, b, prepared, a, Request::collide).collide == collide);
    told[static_cast<std::size_t>(kind)] += is_told;
    meet[static_cast<std::size_t>(kind)] += collide;
  }
  for (std::size_t k = 0; k < shape_kinds; ++k) {
    CAPTURE(name(static_cast<ShapeKind>(k)));
    CHECK(8 * told[k] >= meet[k]);  // most small shapes are not decided
  }
}

TEST_CASE("inner capsule: long thin shapes that are turned any way") {
  Random random(5);
  const NarrowPhase narrow;
  int told = 0;
  for (int round = 0; round < 1500; ++round) {
    const Shape mesh(lump(random, {0.2, 0.2, 2}));
    const Shape other = round % 2 == 0 ? Shape(lump(random, {0.2, 2, 0.2})) : Shape(Box{{0.2, 2, 0.2}});
    make_inner_capsule(mesh, nullptr);
    if (round % 2 == 0) make_inner_capsule(other, nullptr);
    const Pose a = random_pose(random, 0.5), b = random_pose(random, 0.5);
    const bool is_told = meets_inner_capsule({mesh, a}, {other, b});
    told += is_told;
    if (!is_told) continue;
    CAPTURE(round);
    // The distance is computed by the triangles, without the capsule.
    REQUIRE(narrow.solve(mesh, a, other, b, Request::distance).signed_distance <= 0);
  }
  CHECK(told > 100);
}

TEST_CASE("inner capsule: axis-aligned cones in a pocket of a solid are free") {
  // A block with a pocket that opens downwards.
  Mesh block;
  block.solid = true;
  for (const double z : {0.0, 10.0})
    for (const auto& [x, y] : {std::pair{-2.0, -2.0}, {2.0, -2.0}, {2.0, 2.0}, {-2.0, 2.0}})
      block.vertices.emplace_back(x, y, z);
  for (const double z : {0.0, 3.0})
    for (const auto& [x, y] : {std::pair{-1.5, -1.5}, {1.5, -1.5}, {1.5, 1.5}, {-1.5, 1.5}})
      block.vertices.emplace_back(x, y, z);
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t n = (k + 1) % 4;
    block.triangles.push_back({k, n, 4 + n}), block.triangles.push_back({k, 4 + n, 4 + k});                 // sides
    block.triangles.push_back({8 + k, 12 + n, 8 + n}), block.triangles.push_back({8 + k, 12 + k, 12 + n});  // pocket
    block.triangles.push_back({k, 8 + n, n}), block.triangles.push_back({k, 8 + k, 8 + n});                 // border
  }
  block.triangles.push_back({4, 5, 6}), block.triangles.push_back({4, 6, 7});
  block.triangles.push_back({12, 14, 13}), block.triangles.push_back({12, 15, 14});
  const Shape solid(block);
  make_inner_capsule(solid, nullptr);
  REQUIRE(mesh_of(solid).inner_capsule().made()->radius > 0.5);
  const Pose pose;
  for (int r = 1; r < 14; ++r)
    for (int length = 1; length < 18; ++length) {
      const Shape cone = Cone{0.1 * r, 0.1 * length};
      const Pose at{Mat3::Identity(), {0, 0, 1}};
      CAPTURE(r, length);
      REQUIRE_FALSE(meets_inner_capsule({solid, pose}, {cone, at}));
    }
}

TEST_CASE("inner capsule: meshes of any size that shapes may have are prepared") {
  for (const double size : {1e-26, 1e-12, 1e29}) {
    Mesh cube = box_mesh(Vec3(size, size, size));
    cube.solid = true;
    CAPTURE(size);
    CHECK_NOTHROW(prepare(Shape(cube)));
  }
  Mesh far = box_mesh(Vec3(1, 1, 1));
  far.solid = true;
  for (Vec3& v : far.vertices) v += Vec3(1e11, 0, 0);
  const Shape mesh(far), ball = Sphere{0.1};
  prepare(mesh);
  const Pose at, there{Mat3::Identity(), {1e11, 0, 0}};
  CHECK_FALSE(meets_inner_capsule({mesh, at}, {ball, there}));  // rotations need not be that exact
}
