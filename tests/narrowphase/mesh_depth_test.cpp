// The documented properties of the deepest contact of two meshes: a translation that separates them, with a bound on
// how much shorter one might be, for all sizes of bodies and triangles.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "random.h"
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/shape_makers.h"

using namespace tandem;
using namespace tandem::test;

namespace {

/// A solid sphere of radius 1 with dents and bumps of `bump`, of 2 * n * (2 * n - 2) triangles.
Mesh bumpy_sphere(int n, double bump) {
  Mesh mesh;
  mesh.solid = true;
  const int around = 2 * n;
  const auto point = [&](double u, double v) -> Vec3 {
    const double r = 1 + bump * std::sin(9 * u) * std::sin(11 * v);
    return r * Vec3(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v));
  };
  for (int i = 1; i < n; ++i)
    for (int j = 0; j < around; ++j)
      mesh.vertices.push_back(point(2 * std::numbers::pi * j / around, std::numbers::pi * i / n));
  const auto top = static_cast<std::uint32_t>(mesh.vertices.size()), bottom = top + 1;
  mesh.vertices.emplace_back(0, 0, 1);
  mesh.vertices.emplace_back(0, 0, -1);
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>((i - 1) * around + j % around); };
  for (int j = 0; j < around; ++j) {
    mesh.triangles.push_back({top, at(1, j), at(1, j + 1)});
    mesh.triangles.push_back({bottom, at(n - 1, j + 1), at(n - 1, j)});
    for (int i = 1; i + 1 < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

/// For two that collide: the deepest contact is the answer's depth, a translation by it separates if its status is ok,
/// and its bounds agree with the distance's, whose translation separates.
void check_deepest(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double size) {
  const NarrowPhase solver;
  std::vector<Contact> contacts;
  const PairAnswer r = solver.solve(a, pose_a, b, pose_b, Request::contacts, &contacts);
  const PairAnswer d = solver.solve(a, pose_a, b, pose_b, Request::distance);
  REQUIRE(r.collide);
  REQUIRE_FALSE(contacts.empty());
  double deepest = contacts[0].depth;
  for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
  CAPTURE(deepest, r.error_bound, d.signed_distance, d.error_bound);
  CHECK(deepest == -r.signed_distance);
  CHECK((r.status == Status::ok) == (r.error_bound == 0));
  CHECK(deepest - r.error_bound <= -d.signed_distance + 1e-11 * size);
  CHECK(deepest + r.error_bound >= -d.signed_distance - d.error_bound - 1e-11 * size);
  const auto collides_moved = [&](const Vec3& by) {
    return solver.solve(a, pose_a, b, {pose_b.rotation, pose_b.translation + by}, Request::collide).collide;
  };
  CHECK_FALSE(collides_moved((1e-11 * size - d.signed_distance) * d.normal));
  if (r.status == Status::ok) CHECK_FALSE(collides_moved((1e-11 * size + deepest) * r.normal));
}

}  // namespace

TEST_CASE("mesh depth: two bumpy spheres with their centres .95 apart are as deep however fine they are") {
  for (const int n : {12, 24, 72}) {  // 72: 20,448 triangles, of which 9,000 lie inside the other
    const Shape a(bumpy_sphere(n, 0.05));
    const Pose at = Pose::from(Quat(Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized())), {0.3, 0.5, 0.7494});
    CAPTURE(n);
    check_deepest(a, {}, a, at, 2);
    std::vector<Contact> contacts;
    // Each contains a ball of radius .92 about its centre: as long as these overlap, so do the meshes.
    CHECK(-NarrowPhase().solve(a, {}, a, at, Request::contacts, &contacts).signed_distance >= 2 * 0.92 - 0.95);
  }
}

TEST_CASE("mesh depth: bodies sunk into each other") {
  reference::Random random(4711);
  const std::vector<Shape> bodies{Shape(torus(1, 0.4, 16, 8)), Shape(torus(1, 0.2, 9, 5)), Shape(bumpy_sphere(10, 0.1)),
                                  Shape(box_mesh({1, 1.5, 0.7}, 3))};
  int inexact = 0, count = 0;
  for (int k = 0; k < 120; ++k) {
    const Shape &a = bodies[static_cast<std::size_t>(random.below(4))],
                &b = bodies[static_cast<std::size_t>(random.below(4))];
    const Pose pose_a{random.rotation(), Vec3::Zero()}, pose_b{random.rotation(), random.vec_of_length(0.3, 1.5)};
    if (!NarrowPhase().solve(a, pose_a, b, pose_b, Request::collide).collide) continue;
    CAPTURE(k);
    check_deepest(a, pose_a, b, pose_b, 2);
    std::vector<Contact> contacts;
    inexact += NarrowPhase().solve(a, pose_a, b, pose_b, Request::contacts, &contacts).status == Status::inexact;
    ++count;
  }
  CHECK(count > 60);
  CHECK(inexact < count);  // some depths are certain
}

namespace {

/// Each triangle cut at the midpoints of its edges into four.
Mesh cut_at_midpoints(const Mesh& mesh) {
  Mesh finer;
  finer.solid = mesh.solid;
  finer.vertices = mesh.vertices;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> known;
  const auto middle = [&](std::uint32_t p, std::uint32_t q) {
    const auto [at, fresh] = known.emplace(std::minmax(p, q), static_cast<std::uint32_t>(finer.vertices.size()));
    if (fresh) finer.vertices.push_back((mesh.vertices[p] + mesh.vertices[q]) / 2);
    return at->second;
  };
  for (const auto& [p, q, r] : mesh.triangles) {
    const std::uint32_t pq = middle(p, q), qr = middle(q, r), rp = middle(r, p);
    finer.triangles.push_back({p, pq, rp});
    finer.triangles.push_back({pq, q, qr});
    finer.triangles.push_back({rp, qr, r});
    finer.triangles.push_back({pq, qr, rp});
  }
  return finer;
}

/// An open square of 2 x 2 about the origin, of 2 * n * n triangles, with random heights up to `most`.
Mesh rough_square(int n, double most, reference::Random& random) {
  Mesh mesh;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) mesh.vertices.emplace_back(2.0 * i / n - 1, 2.0 * j / n - 1, random.in(-most, most));
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

double depth_without_bounds(const Shape& a, const Shape& b, const Pose& at) {
  std::vector<Contact> contacts;
  return -NarrowPhase({.mesh_bounds = false}).solve(a, {}, b, at, Request::contacts, &contacts).signed_distance;
}

}  // namespace

// Where edges of two bodies cross, the deepest point lies on neither's corner: in a finer mesh on an edge whose ends
// are both inside the other mesh. Edges with an end outside alone were examined: of 200 pairs 96 were shallower.
TEST_CASE("mesh depth: contacts of finer meshes of the same bodies are as deep") {
  const Mesh tube = torus(1, 0.35, 7, 4);
  const Shape coarse(tube), fine(cut_at_midpoints(cut_at_midpoints(tube)));
  reference::Random random(5);
  int count = 0, shallower = 0;
  while (count < 200) {
    const Mat3 rotation = random.rotation();
    const Pose at{rotation, random.vec_of_length(0.3, 2)};
    const PairAnswer distance = NarrowPhase().solve(coarse, {}, coarse, at, Request::distance);
    if (!distance.collide || distance.signed_distance < -0.3) continue;
    ++count;
    if (depth_without_bounds(fine, fine, at) < 0.99 * depth_without_bounds(coarse, coarse, at)) ++shallower;
  }
  CHECK(shallower <= 9);
}

TEST_CASE("mesh depth: an open surface that overlaps a body has a contact with a depth") {
  reference::Random random(7);
  const Shape square(rough_square(6, 0.2, random)), tube(torus(1, 0.4, 12, 7));
  int count = 0, without = 0;
  while (count < 400) {
    const Mat3 rotation = random.rotation();
    const Pose at{rotation, random.vec_of_length(0.3, 2)};
    const PairAnswer distance = NarrowPhase().solve(square, {}, tube, at, Request::distance);
    if (!distance.collide || distance.signed_distance < -0.1 || distance.signed_distance > -1e-6) continue;
    ++count;
    if (depth_without_bounds(square, tube, at) < 1e-9) ++without;
  }
  CHECK(without <= 2);
}

// The search for a shorter translation is left out for large meshes, the points of contact are not.
TEST_CASE("mesh depth: contacts of large meshes lie within half their depth of both") {
  const Shape a(torus(1, 0.4, 30, 16)), b(torus(1, 0.4, 20, 12)), point(Sphere{0});
  reference::Random random(6);
  const NarrowPhase solver;
  int count = 0;
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i);
    const Mat3 rotation = random.rotation();
    const Pose at{rotation, random.vec_of_length(0.3, 2)};
    std::vector<Contact> contacts;
    if (!solver.solve(a, {}, b, at, Request::contacts, &contacts).collide) continue;
    for (const Contact& c : contacts) {
      const Pose there{Mat3::Identity(), c.point};
      CHECK(solver.solve(a, {}, point, there, Request::distance).signed_distance <= c.depth / 2 + 1e-6);
      CHECK(solver.solve(b, at, point, there, Request::distance).signed_distance <= c.depth / 2 + 1e-6);
    }
    ++count;
  }
  CHECK(count > 150);
}

TEST_CASE("mesh depth: contacts scale with the bodies") {
  const Mesh tube = torus(1, 0.4, 12, 7);
  reference::Random random(11);
  for (int k = 0; k < 20; ++k) {
    const Mat3 turn = random.rotation();
    const Vec3 move = random.vec_of_length(0.8, 1.6);
    std::vector<Contact> expected;
    const PairAnswer r = NarrowPhase().solve(Shape(tube), {}, Shape(tube), {turn, move}, Request::contacts, &expected);
    for (const int power : {-80, -40, -28, 30, 80}) {
      const double factor = std::ldexp(1.0, power);
      Mesh scaled = tube;
      for (Vec3& v : scaled.vertices) v *= factor;
      std::vector<Contact> contacts;
      const PairAnswer s =
          NarrowPhase().solve(Shape(scaled), {}, Shape(scaled), {turn, factor * move}, Request::contacts, &contacts);
      CAPTURE(k, power);
      CHECK(s.signed_distance == Approx(factor * r.signed_distance).epsilon(1e-12));
      REQUIRE(contacts.size() == expected.size());
      for (std::size_t i = 0; i < contacts.size(); ++i) {
        CHECK(contacts[i].feature == expected[i].feature);
        CHECK(contacts[i].depth == Approx(factor * expected[i].depth).epsilon(1e-12));
      }
    }
  }
}

namespace {

using Cells = std::vector<std::array<std::int32_t, 3>>;

// Without two alike, of a grid of 2 x 2 x 2.
Cells some_cells(reference::Random& r) {
  std::set<std::array<std::int32_t, 3>> cells;
  for (int n = 1 + r.below(4); n > 0; --n) {
    const int bits = r.below(8);
    cells.insert({bits & 1, bits >> 1 & 1, bits >> 2});
  }
  return {cells.begin(), cells.end()};
}

// Do solids of such unit cubes, the second `by` farther on, touch without overlap, and do they part when it is moved a
// little into one of the eight octants?
bool touch(const Cells& a, const Cells& b, const std::array<int, 3>& by) {
  const auto off = [&](const auto& p, const auto& q, std::size_t k) { return q[k] + by[k] - p[k]; };
  bool any = false;
  for (int octant = 0; octant < 8; ++octant) {
    bool overlap = false;
    for (const auto& p : a)
      for (const auto& q : b) {
        bool meet = true, closed = true;
        for (std::size_t k = 0; k < 3; ++k) {
          const int d = off(p, q, k), step = (octant >> k & 1) != 0 ? 1 : -1;
          closed = closed && std::abs(d) <= 1;
          meet = meet && (d == 0 || d == -step);
        }
        any = any || closed;
        overlap = overlap || meet;
      }
    if (any && !overlap) return true;
  }
  return false;
}

// Solids of these cubes, and of more triangles.
Shape with(const Cells& cells, const Mesh& more) {
  const Shape cubes = voxel_mesh(cells, 1);
  Mesh all{mesh_of(cubes).vertices, mesh_of(cubes).triangles, true};
  const auto before = static_cast<std::uint32_t>(all.vertices.size());
  all.vertices.insert(all.vertices.end(), more.vertices.begin(), more.vertices.end());
  for (const auto& t : more.triangles) all.triangles.push_back({t[0] + before, t[1] + before, t[2] + before});
  return Shape(all);
}

}  // namespace

TEST_CASE("mesh depth: solids of cubes hooked into each other that only touch are 0 deep") {
  reference::Random r(8);
  const NarrowPhase n;
  int touching = 0;
  for (int i = 0; i < 3000; ++i) {
    const Cells a = some_cells(r), b = some_cells(r);
    const std::array<int, 3> by{r.below(5) - 2, r.below(5) - 2, r.below(5) - 2};
    if (!touch(a, b, by)) continue;
    ++touching;
    CAPTURE(i);
    const Shape first = voxel_mesh(a, 1), second = voxel_mesh(b, 1);
    const Pose at = Pose::at(by[0], by[1], by[2]);
    const PairAnswer distance = n.solve(first, {}, second, at, Request::distance);
    REQUIRE(distance.collide);
    REQUIRE(distance.signed_distance == Approx(0).margin(1e-11));
    for (const bool bounds : {true, false}) {
      std::vector<Contact> contacts;
      NarrowPhase({.mesh_bounds = bounds}).solve(first, {}, second, at, Request::contacts, &contacts);
      REQUIRE_FALSE(contacts.empty());
      for (const Contact& c : contacts) REQUIRE(c.depth == Approx(0).margin(1e-11));
    }
  }
  CHECK(touching > 1000);
}

// A touch says nothing about other contacts: those that are right stay. Of some 1,200 pairs, in 340 the tip touches
// where nothing else is wrong, in 150 beside contacts that are.
TEST_CASE("mesh depth: where solids hooked into each other only touch, other contacts stay") {
  reference::Random r(8);
  int hooked = 0, kept = 0;
  for (int i = 0; i < 3000; ++i) {
    Cells a = some_cells(r);
    const Cells b = some_cells(r);
    const std::array<int, 3> by{r.below(5) - 2, r.below(5) - 2, r.below(5) - 2};
    if (!touch(a, b, by)) continue;
    // On a cube far off stands a tetrahedron's tip.
    const Vec3 tip = Vec3(20.5, 0.25, 1) - Vec3(by[0], by[1], by[2]);
    const Mesh stands{{tip, tip + Vec3(0.1, 0, 0.5), tip + Vec3(-0.1, 0.1, 0.5), tip + Vec3(-0.1, -0.1, 0.5)},
                      {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}},
                      true};
    a.push_back({20, 0, 0});
    std::vector<Contact> contacts;
    NarrowPhase({.mesh_bounds = false})
        .solve(voxel_mesh(a, 1), {}, with(b, stands), Pose::at(by[0], by[1], by[2]), Request::contacts, &contacts);
    CAPTURE(i);
    if (std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.depth > 1e-9; })) continue;
    ++hooked;
    kept += std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.point.x() > 20; }) ? 1 : 0;
  }
  CAPTURE(kept, hooked);
  CHECK(kept > 450);
  CHECK(hooked > 1000);
}

// Coordinates there are 4e-12 apart, more than a translation that rounding of such small bodies needs.
TEST_CASE("mesh depth: solids that touch are 0 deep far from their origin, too") {
  reference::Random r(8);
  const NarrowPhase n;
  int touching = 0, parted = 0;
  constexpr int far = 20000;
  for (int i = 0; i < 3000; ++i) {
    Cells a = some_cells(r);
    const Cells b = some_cells(r);
    const std::array<int, 3> by{r.below(5) - 2, r.below(5) - 2, r.below(5) - 2};
    if (!touch(a, b, by)) continue;
    ++touching;
    CAPTURE(i);
    for (auto& cell : a) cell[0] += far;
    const Shape first = voxel_mesh(a, 1), second = voxel_mesh(b, 1);
    const Pose at = Pose::at(far + by[0], by[1], by[2]);
    const PairAnswer distance = n.solve(first, {}, second, at, Request::distance);
    REQUIRE(distance.collide);
    REQUIRE(distance.signed_distance == Approx(0).margin(1e-9));
    std::vector<Contact> contacts;
    NarrowPhase({.mesh_bounds = false}).solve(first, {}, second, at, Request::contacts, &contacts);
    REQUIRE_FALSE(contacts.empty());
    for (const Contact& c : contacts) REQUIRE(c.depth == Approx(0).margin(1e-9));
    // Moved by the depth, and what coordinates are rounded by, they part.
    const Vec3 moved = at.translation + (1e-10 - distance.signed_distance) * distance.normal;
    parted += n.solve(first, {}, second, {at.rotation, moved}, Request::collide).collide ? 0 : 1;
  }
  CHECK(touching > 1000);
  CHECK(parted == touching);
}

namespace {

/// A solid of height 2 h about z = 0, the outline of which is an L.
Mesh angle_iron(double length, double width, double h) {
  return prism({{0, 0}, {length, 0}, {length, width}, {width, width}, {width, length}, {0, length}},
               {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, 2 * h);
}

/// Checks that what rests on a plate whose top is at z = 0 is pushed up, by its distance and its contacts.
void check_pushed_up(const Shape& plate, const Shape& body, const Pose& at) {
  const PairAnswer distance = NarrowPhase().solve(plate, {}, body, at, Request::distance);
  REQUIRE(distance.collide);
  CHECK((distance.normal - Vec3::UnitZ()).norm() < 1e-9);
  std::vector<Contact> contacts;
  NarrowPhase().solve(plate, {}, body, at, Request::contacts, &contacts);
  CHECK(contacts.size() >= 3);
  for (const Contact& c : contacts) CHECK((c.normal - Vec3::UnitZ()).norm() < 1e-9);
}

}  // namespace

TEST_CASE("mesh depth: a concave solid that rests on a plate leaves it along the plate's normal") {
  reference::Random r(12);
  for (int i = 0; i < 200; ++i) {
    const double h = (1 + r.below(8)) / 16.0, length = (9 + r.below(8)) / 16.0;
    Mesh slab = box_mesh({2, 2.5, 0.5});
    for (Vec3& v : slab.vertices) v.z() -= 0.25;
    const double turn = r.in(0, 7), x = r.in(-0.5, 0.5);
    Pose at = Pose::at(x, r.in(-0.5, 0.5), h);
    at.rotation << std::cos(turn), -std::sin(turn), 0, std::sin(turn), std::cos(turn), 0, 0, 0, 1;
    CAPTURE(i);
    check_pushed_up(Shape{slab}, Shape{angle_iron(length, 0.25, h)}, at);
  }
}

TEST_CASE("mesh depth: triangles that are also there with the opposite orientation do not change how a body rests") {
  reference::Random r(13);
  for (int i = 0; i < 100; ++i) {
    Mesh slab = box_mesh({2, 2.5, 0.5}, 1 + r.below(5)), body = box_mesh({0.75, 1, 0.5}, 1 + r.below(4));
    for (Vec3& v : slab.vertices) v.z() -= 0.25;
    for (Mesh* mesh : {&slab, &body})
      for (int k = 0; k < 6; ++k) {
        const auto t = mesh->triangles[static_cast<std::size_t>(r.below(static_cast<int>(mesh->triangles.size())))];
        mesh->triangles.push_back(t);
        mesh->triangles.push_back({t[0], t[2], t[1]});
      }
    const double x = r.in(-0.6, 0.6);
    CAPTURE(i);
    check_pushed_up(Shape{slab}, Shape{body}, Pose::at(x, r.in(-0.7, 0.7), 0.25));
  }
}

// Rounding decides which triangles intersect: those of one face alone would let the box slide along the other.
TEST_CASE("mesh depth: a box flush in the corner of a concave solid leaves both faces, not along one") {
  reference::Random r(14);
  const Shape iron{angle_iron(2, 0.3, 1)};
  int touching = 0;
  for (int i = 0; i < 300; ++i) {
    const Vec3 half = r.vec(0.3, 0.5);
    const Shape box{box_mesh(2 * half, 1 + i % 3)};
    const Pose at_iron{r.rotation(), r.vec(-2, 2)};
    // The tops in one plane, or not.
    const double z = i % 2 == 0 ? r.in(-0.3, 0.3) : 1 - half.z();
    const Pose at{at_iron.rotation, at_iron * Vec3(0.3 + half.x(), 0.3 + half.y(), z)};
    const PairAnswer distance = NarrowPhase().solve(iron, at_iron, box, at, Request::distance);
    touching += distance.collide ? 1 : 0;
    CAPTURE(i, distance.signed_distance, distance.error_bound);
    CHECK(distance.status == Status::ok);
    CHECK(std::abs(distance.signed_distance) < 1e-12);
    const Vec3 out = at_iron.rotation.transpose() * distance.normal;
    CHECK(out.x() > -1e-9);
    CHECK(out.y() > -1e-9);
    CHECK(std::abs(out.z()) < 1e-9);
    for (const double far : {1e-10, 1e-6, 1e-3}) {
      const Pose moved{at.rotation, at.translation + (far - distance.signed_distance) * distance.normal};
      CHECK_FALSE(NarrowPhase().solve(iron, at_iron, box, moved, Request::collide).collide);
    }
  }
  CHECK(touching > 150);
}

namespace {

// Does a small translation of the second of two solids of cubes, which only touch, lead into a cube of the first?
bool leads_into(const Vec3& n, const Cells& a, const Cells& b, const std::array<int, 3>& by) {
  for (const auto& p : a)
    for (const auto& q : b) {
      bool into = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const int d = q[k] + by[k] - p[k];
        into = into && std::abs(d) <= 1 && (d == 0 || d * n[static_cast<Eigen::Index>(k)] < -1e-9);
      }
      if (into) return true;
    }
  return false;
}

}  // namespace

TEST_CASE("mesh depth: solids of cubes that touch, rotated, leave each other, wherever else they touch") {
  reference::Random r(15);
  int touching = 0, apart = 0;
  for (int i = 0; i < 3000; ++i) {
    const Cells a = some_cells(r), b = some_cells(r);
    const std::array<int, 3> by{r.below(5) - 2, r.below(5) - 2, r.below(5) - 2};
    const Pose at_a{r.rotation(), r.vec(-3, 3)};
    if (!touch(a, b, by)) continue;
    ++touching;
    CAPTURE(i);
    const Pose at_b{at_a.rotation, at_a * Vec3(by[0], by[1], by[2])};
    const PairAnswer distance = NarrowPhase().solve(voxel_mesh(a, 1), at_a, voxel_mesh(b, 1), at_b, Request::distance);
    apart += distance.collide ? 0 : 1;
    CHECK(std::abs(distance.signed_distance) < 1e-11);
    CHECK_FALSE(leads_into(at_a.rotation.transpose() * distance.normal, a, b, by));
  }
  CHECK(touching > 1000);
  CHECK(apart > 300);
}
