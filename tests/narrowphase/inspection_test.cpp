// Faults of meshes.
#include "tandem/narrowphase/inspection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.h"
#include "random.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;

namespace {

void append(Mesh& mesh, const Mesh& other, const Vec3& shift, bool turned = false) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3& v : other.vertices) mesh.vertices.push_back(v + shift);
  for (const auto& t : other.triangles)
    mesh.triangles.push_back(turned ? std::array{first + t[0], first + t[2], first + t[1]}
                                    : std::array{first + t[0], first + t[1], first + t[2]});
}

// With eight vertices.
Mesh cube(double size) {
  Mesh mesh;
  for (int i = 0; i < 8; ++i)
    mesh.vertices.emplace_back(size * ((i & 1) - 0.5), size * (i / 2 % 2 - 0.5), size * (i / 4 - 0.5));
  for (const auto& [a, b, c, d] : std::vector<std::array<std::uint32_t, 4>>{
           {0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return mesh;
}

}  // namespace

TEST_CASE("inspection: a clean solid has nothing to tell") {
  const MeshInspection found = inspect(cube(2));
  CHECK(found.is_clean_solid());
  CHECK(found.components == 1);
  CHECK(found.duplicate_vertices.count == 0);
  Mesh two = cube(2);
  append(two, cube(1), {5, 0, 0});
  CHECK(inspect(two).is_clean_solid());
  CHECK(inspect(two).components == 2);
}

TEST_CASE("inspection: edges that do not join two triangles in opposite sense, by kind") {
  Mesh open = cube(2);
  const auto removed = open.triangles.back();
  open.triangles.pop_back();
  const MeshInspection hole = inspect(open);
  REQUIRE(hole.faulty_edges.count == 3);
  CHECK_FALSE(hole.closed());
  for (const FaultyEdge& e : hole.faulty_edges.first) {
    CHECK(e.fault == EdgeFault::open);
    CHECK(e.forward + e.backward == 1);
    for (std::size_t k = 0; k < 2; ++k) {
      CHECK(std::find(removed.begin(), removed.end(), e.vertices[k]) != removed.end());
      CHECK(e.ends[k] == open.vertices[e.vertices[k]]);
    }
  }
  Mesh turned = cube(2);
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  const MeshInspection wrong = inspect(turned);
  REQUIRE(wrong.faulty_edges.count == 3);
  for (const FaultyEdge& e : wrong.faulty_edges.first) CHECK(e.fault == EdgeFault::inconsistent);
  // Two boxes that share an edge.
  Mesh joined = cube(2);
  append(joined, cube(2), {2, 2, 0});
  const MeshInspection shared = inspect(joined);
  REQUIRE(shared.faulty_edges.count == 1);
  CHECK(shared.faulty_edges.first[0].fault == EdgeFault::non_manifold);
  CHECK(shared.faulty_edges.first[0].forward == 2);
  CHECK(shared.duplicate_vertices.count == 2);
  CHECK(shared.self_intersections.count == 0);
  CHECK(name(EdgeFault::non_manifold) == "non-manifold");
}

TEST_CASE("inspection: duplicates and triangles without area") {
  Mesh mesh = cube(2);
  const auto vertices = static_cast<std::uint32_t>(mesh.vertices.size());
  const auto triangles = static_cast<std::uint32_t>(mesh.triangles.size());
  mesh.vertices.push_back(mesh.vertices[mesh.triangles[5][1]]);
  mesh.triangles.push_back({mesh.triangles[5][2], vertices, mesh.triangles[5][0]});
  // Points on a line, and nearly so.
  mesh.vertices.insert(mesh.vertices.end(), {Vec3(7, 0, 0), Vec3(8, 1, 1), Vec3(10, 3, 3), Vec3(10, 3, 3 + 1e-15)});
  mesh.triangles.push_back({vertices + 1, vertices + 2, vertices + 3});
  mesh.triangles.push_back({vertices + 1, vertices + 2, vertices + 4});
  const MeshInspection found = inspect(mesh);
  REQUIRE(found.duplicate_vertices.count == 1);
  CHECK(found.duplicate_vertices.first[0].vertex == vertices);
  CHECK(found.duplicate_vertices.first[0].same_as == mesh.triangles[5][1]);
  REQUIRE(found.duplicate_triangles.count == 1);
  CHECK(found.duplicate_triangles.first[0].triangle == triangles);
  CHECK(found.duplicate_triangles.first[0].same_as == 5);
  REQUIRE(found.flat_triangles.count == 1);
  CHECK(found.flat_triangles.first[0].triangle == triangles + 1);
}

TEST_CASE("inspection: a component inside out, but not a cavity's border") {
  Mesh mesh = cube(4);
  append(mesh, cube(1), {0, 0, 0}, true);  // a cavity
  CHECK(inspect(mesh).is_clean_solid());
  const auto first = static_cast<std::uint32_t>(mesh.triangles.size());
  append(mesh, cube(1), {9, 0, 0}, true);
  const MeshInspection found = inspect(mesh);
  CHECK(found.components == 3);
  REQUIRE(found.inside_out.count == 1);
  CHECK(found.inside_out.first[0].triangle == first);
  CHECK(found.inside_out.first[0].volume == Approx(-1));
  CHECK(found.inside_out.first[0].triangles == 12);
  CHECK_FALSE(found.is_clean_solid());
}

TEST_CASE("inspection: triangles that cross, also beside corners and edges that they share") {
  const auto crossings = [](const Mesh& mesh) { return inspect(mesh).self_intersections.count; };
  const std::vector<Vec3> places{{0, 0, 0}, {4, 0, 0}, {0, 4, 0},  {1, 1, 1}, {1, 1, -1},
                                 {1, 1, 2}, {9, 9, 0}, {3, -1, 0}, {1, 2, 0}};
  const auto two = [&](std::array<std::uint32_t, 3> a, std::array<std::uint32_t, 3> b) {
    return crossings(Mesh{places, {a, b}, false});
  };
  CHECK(two({0, 1, 2}, {3, 4, 6}) == 1);  // no shared corner
  CHECK(two({0, 1, 2}, {3, 5, 6}) == 0);
  CHECK(two({0, 1, 2}, {0, 3, 4}) == 1);  // corner 0 is shared
  CHECK(two({0, 3, 4}, {0, 1, 2}) == 1);  // the reverse
  CHECK(two({0, 1, 2}, {0, 3, 5}) == 0);
  CHECK(two({0, 1, 2}, {0, 1, 3}) == 0);  // an edge is shared
  CHECK(two({0, 1, 2}, {0, 1, 7}) == 0);  // in one plane, side by side
  CHECK(two({0, 1, 2}, {0, 1, 8}) == 1);  // in one plane, overlapping
  Mesh overlapping = cube(2);
  append(overlapping, cube(2), {1, 1, 1});
  const MeshInspection found = inspect(overlapping);
  CHECK(found.self_intersections.count > 6);
  for (const SelfIntersection& s : found.self_intersections.first) {
    CHECK(s.triangles[0] < 12);
    CHECK(s.triangles[1] >= 12);
    CHECK((s.place.array() >= -1).all());
    CHECK((s.place.array() <= 2).all());
  }
  InspectionOptions few;
  few.most = 2;
  const MeshInspection bounded = inspect(overlapping, few);
  CHECK(bounded.self_intersections.count == found.self_intersections.count);
  REQUIRE(bounded.self_intersections.first.size() == 2);
  CHECK(bounded.self_intersections.first[1].triangles == found.self_intersections.first[1].triangles);
}

TEST_CASE("inspection: crossings of a heap of triangles are those of each pair") {
  reference::Random random(3);
  Mesh heap;
  for (std::uint32_t i = 0; i < 300; ++i) {
    const Vec3 at = random.vec(0, 4);
    for (int k = 0; k < 3; ++k) heap.vertices.push_back(at + random.vec(-0.5, 0.5));
    heap.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  std::size_t count = 0;
  const NarrowPhase narrow;
  const auto triangle = [&](std::size_t i) {
    return Shape(Triangle{{heap.vertices[3 * i], heap.vertices[3 * i + 1], heap.vertices[3 * i + 2]}});
  };
  for (std::size_t i = 0; i < 300; ++i)
    for (std::size_t j = 0; j < i; ++j)
      count += narrow.solve(triangle(i), {}, triangle(j), {}, Request::collide).collide;
  CHECK(count > 50);
  CHECK(inspect(heap).self_intersections.count == count);
}

TEST_CASE("inspection: what is no mesh is refused") {
  CHECK_THROWS_WITH(inspect(Mesh{}), Catch::Contains("no triangles"));
  CHECK_THROWS_WITH(inspect(Mesh{{Vec3(0, 0, 0)}, {{0, 0, 1}}, false}), Catch::Contains("vertex 1, must be below 1"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(inspect(Mesh{{Vec3(0, nan, 0)}, {{0, 0, 0}}, false}),
                    Catch::Contains("vertices[0] is (0, nan, 0)"));
}

TEST_CASE("a mesh's inspection: its crossings end at a limit, and equal triangles are not paired with each other") {
  Mesh fan;
  fan.vertices.emplace_back(0, 0, 0);
  constexpr std::uint32_t n = 400;
  for (std::uint32_t i = 0; i < n; ++i) {
    const double at = 6.28 * i / n;
    fan.vertices.emplace_back(std::cos(at), std::sin(at), 0.001 * (i % 2));
    if (i > 0) fan.triangles.push_back({0, i, i + 1});
  }
  int asked = 0;
  const WorkLimit limit{.ended = [&] { return ++asked > 3; }};
  CHECK_THROWS_AS(inspect(fan, {.limit = &limit}), WorkStopped);
  CHECK(asked == 4);
  CHECK(inspect(fan).self_intersections.count == 0);

  Mesh equal;
  for (const Vec3& v : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}) equal.vertices.push_back(v);
  equal.triangles.assign(20000, {0, 1, 2});
  asked = 0;
  const WorkLimit counting{.ended = [&] { return ++asked > 1000; }};
  CHECK(inspect(equal, {.limit = &counting}).duplicate_triangles.count == 19999);
  CHECK(asked < 10);
}
