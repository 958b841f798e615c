// The methods of the search for a translation that separates, each tested alone: a box in a channel with a floor, as a
// mesh and as a convex shape, where the shortest translation is known.
#include <cmath>

#include "catch.h"
#include "mesh_samples.h"
#include "meshes/depth/convex_in_mesh.h"
#include "meshes/depth/overlapping_meshes.h"
#include "meshes/mesh_pair.h"

using namespace tandem;
using namespace tandem::test;

namespace {

/// A solid block of 4 x 4 x 3 with a channel along y, 2 wide and 2 deep, in its top; the channel's floor is at z = 0.
Mesh channel() {
  const std::array<std::array<double, 2>, 8> outline{
      {{-2, -1}, {2, -1}, {2, 2}, {1, 2}, {1, 0}, {-1, 0}, {-1, 2}, {-2, 2}}};
  Mesh mesh;
  mesh.solid = true;
  for (const double y : {-2.0, 2.0})
    for (const auto& [x, z] : outline) mesh.vertices.emplace_back(x, y, z);
  const std::array<std::array<std::uint32_t, 3>, 6> front{
      {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}}};
  for (const auto& [i, j, k] : front) {
    mesh.triangles.push_back({i, j, k});
    mesh.triangles.push_back({i + 8, k + 8, j + 8});
  }
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::uint32_t j = (i + 1) % 8;
    mesh.triangles.push_back({i, i + 8, j + 8});
    mesh.triangles.push_back({i, j + 8, j});
  }
  return mesh;
}

/// The results of each method for a cube of side 1 that has sunk into the channel's floor by 0.1 and its right wall by
/// 0.15.
void check_methods(OverlappingPair& pair) {
  const Vec3 shortest(-0.15, 0, 0.1);
  REQUIRE(pair.collide(Vec3::Zero()));
  CHECK(pair.is_free(1.0001 * shortest));
  CHECK_FALSE(pair.is_free(0.9999 * shortest));
  SECTION("along a direction") {
    SeparationSearch search(pair, {});
    search.along(Vec3::UnitZ());
    CHECK(search.known.length >= 2.1);
    CHECK(search.known.length <= 2.11);
    CHECK(search.known.normal == Vec3::UnitZ());
    CHECK_FALSE(search.is_shortest());
  }
  SECTION("beyond constraints") {
    SeparationSearch search(pair, {});
    const std::array<Constraint, 2> blocked{{{Vec3::UnitZ(), 0.1}, {-Vec3::UnitX(), 0.1}}};
    search.beyond(blocked);
    CHECK(std::isinf(search.known.length));
    const std::array<Constraint, 2> free{{{Vec3::UnitZ(), 0.3}, {-Vec3::UnitX(), 0.4}}};
    search.beyond(free);
    CHECK(std::abs(search.known.length - 0.5) < 1e-12);
  }
  SECTION("beyond obstacles: the shortest, and certain to be") {
    SeparationSearch search(pair, {});
    search.beyond_obstacles();
    CHECK((search.known.length * search.known.normal - shortest).norm() < 1e-11);
    CHECK(search.is_shortest());
    CHECK(search.answer().status == Status::ok);
  }
  SECTION("shorten: down to the shortest; confirm: it is certain then") {
    SeparationSearch search(pair, {.length = 1, .normal = Vec3(-0.6, 0, 0.8)});
    search.shorten();
    CHECK((search.known.length * search.known.normal - shortest).norm() < 1e-7);
    CHECK(search.known.certain == 0);
    search.confirm();
    CHECK(search.known.certain > 0.99 * shortest.norm());
  }
}

const Shape block{channel()};
const Pose at_block;
const Pose sunk = Pose::at(0.65, 0.1, 0.4);

}  // namespace

TEST_CASE("search for a separating translation: two meshes") {
  const Shape cube{box_mesh({1, 1, 1}, 2)};
  const Posed a{block, at_block}, b{cube, sunk};
  const NarrowPhaseOptions none;
  TriangleTest test(a.pose, b.pose, reach(mesh_of(b.shape)));
  PairMemory memory(std::pmr::get_default_resource());
  const TrianglePairs pairs = meeting_pairs(a, b, test, none, memory, nullptr);
  OverlappingMeshes pair(a, b, pairs, none);
  check_methods(pair);
}

TEST_CASE("search for a separating translation: a convex shape in a mesh") {
  const Shape cube{Box{{1, 1, 1}}};
  const NarrowPhaseOptions options;
  const MeshConvexPair placed({block, at_block}, {cube, sunk}, options);
  ConvexInMesh pair(placed);
  check_methods(pair);
}

TEST_CASE("constraints: the shortest translation, the strongest of alike ones, and how far they reach") {
  LocalConstraints constraints(1e-13);
  CHECK(constraints.add({{Vec3::UnitX(), 1}, 5, Vec3::Zero()}));
  CHECK_FALSE(constraints.add({{Vec3::UnitX(), 0.5}, 4, Vec3::Zero()}));
  CHECK(constraints.add({{Vec3::UnitX(), 2}, 3, Vec3(7, 0, 0)}));
  CHECK(constraints.add({{Vec3::UnitY(), 1}, 5, Vec3::Zero()}));
  Vec3 t;
  REQUIRE(constraints.shortest(0, 0, t));
  CHECK(t == Vec3(2, 1, 0));
  CHECK(constraints.active_at(t)->point == Vec3(7, 0, 0));
  REQUIRE(constraints.shortest(4, 0, t));
  CHECK(t == Vec3(1, 1, 0));
  CHECK(constraints.add({{-Vec3::UnitX(), 0}, 5, Vec3::Zero()}));
  CHECK_FALSE(constraints.shortest(0, 0, t));
}
