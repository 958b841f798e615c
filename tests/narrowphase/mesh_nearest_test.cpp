// Distances of meshes, compared with all pairs of triangles.
#include "meshes/traversal/mesh_nearest.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "random.h"
#include "shapes/mesh_builder.h"
#include "shapes/shape_insides.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tolerances.h"

using namespace tandem;
using namespace tandem::test;

namespace {

std::uint32_t index(reference::Random& random, std::size_t count) {
  return static_cast<std::uint32_t>(random.below(static_cast<int>(count)));
}

/// Made of triangles about the poles and the meridians between them.
Mesh sphere(double radius, int rows) {
  Mesh mesh;
  const int columns = 2 * rows;
  for (int i = 0; i <= rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const double down = std::numbers::pi * i / rows, round = std::numbers::pi * j / rows;
      mesh.vertices.push_back(radius *
                              Vec3(std::sin(down) * std::cos(round), std::sin(down) * std::sin(round), std::cos(down)));
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * columns + j % columns); };
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      if (i > 0) mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < rows) mesh.triangles.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  return mesh;
}

/// Random triangles, some of them needles or degenerate.
Mesh soup(reference::Random& random, std::size_t triangles, double scale) {
  Mesh mesh;
  for (std::uint32_t i = 0; i < triangles; ++i) {
    const Vec3 middle = random.vec(-1, 1), along = random.once_in(2) ? Vec3::UnitX() : random.direction();
    const double size = random.power_of_two(-8, 0);
    const int form = static_cast<int>(i % 4);
    for (int k = 0; k < 3; ++k) {
      Vec3 corner = middle + size * random.vec(-1, 1);
      if (form == 1) corner = middle + size * k * along + 1e-9 * random.vec(-1, 1);  // a needle
      if (form == 2 && k == 2) corner = mesh.vertices.back() / scale;                // a segment
      mesh.vertices.push_back(scale * corner);
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

/// All against all, by the solver of single triangles.
double least_distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  double least = infinity;
  const NarrowPhase solver;
  std::vector<Shape> of_b;
  for (std::uint32_t y = 0; y < mesh_of(b).triangles.size(); ++y) of_b.emplace_back(Triangle{mesh_of(b).corners(y)});
  for (std::uint32_t x = 0; x < mesh_of(a).triangles.size(); ++x) {
    const Shape t(Triangle{mesh_of(a).corners(x)});
    for (const Shape& other : of_b)
      least = std::min(least, solver.solve(t, pose_a, other, pose_b, Request::distance).signed_distance);
  }
  return least;
}

/// The triangles below a node of the hierarchy.
void collect(const MeshModel& mesh, std::uint32_t ref, std::vector<std::uint32_t>& out) {
  if (is_leaf(mesh, ref)) return out.push_back(leaf_triangle(mesh, ref));
  each_child(mesh, ref, [&](std::uint32_t child) { collect(mesh, child, out); });
}

}  // namespace

TEST_CASE("bounds between parts of two meshes hold for all triangles in them, and are close to the nearest") {
  reference::Random random(77);
  const MeshModel a = build_mesh(torus(1, 0.4, 24, 12));
  Mesh small = sphere(0.3, 6);
  for (Vec3& v : small.vertices) v += Vec3(3, 2, 1);
  const MeshModel b = build_mesh(small);
  double bounds = 0, distances = 0;
  int held = 0;
  for (int i = 0; i < 300; ++i) {
    const Mat3 turn = random.rotation();
    const Vec3 shift = random.vec_of_length(1.2, 1.8) - turn * b.centre;
    const MeshView seen{b, turn, (turn * b.centre + shift - a.centre) / a.unit, a.unit};
    const std::uint32_t above = index(random, b.nodes.size());
    const std::uint32_t ref = i % 7 == 0 ? whole : child_ref(above, index(random, b.nodes[above].lanes()));
    const NearVolume volume = seen.volume(ref);
    const std::uint32_t number = index(random, a.nodes.size());
    const MeshNode& node = a.nodes[number];
    const Vec3 ahead = random.direction();
    const NearPlane plane{ahead, volume.reach(ahead)};
    std::array<double, mesh_lanes> least;
    bound_distances(volume, plane, a, node, infinity, least);
    std::array<double, mesh_lanes> some;
    const double enough = least[static_cast<std::size_t>(i) % node.lanes()];
    bound_distances(volume, plane, a, node, enough, some);
    for (std::uint32_t k = 0; k < node.lanes(); ++k)
      CHECK((least[k] <= enough ? some[k] == least[k] : some[k] > enough && some[k] <= least[k]));
    std::vector<std::uint32_t> in_volume;
    collect(b, ref, in_volume);
    for (std::uint32_t k = 0; k < node.lanes(); ++k) {
      std::vector<std::uint32_t> in_child;
      collect(a, child_ref(number, k), in_child);
      Nearest nearest;
      for (const std::uint32_t x : in_child)
        for (const std::uint32_t y : in_volume) {
          Corners q = b.corners(y);
          for (Vec3& corner : q) corner = turn * corner + shift;
          triangles_nearest(a.corners(x), q, nearest);
        }
      CAPTURE(i, k);
      CHECK(a.unit * (least[k] - bounds_off) <= nearest.distance);
      bounds += a.unit * least[k], distances += nearest.distance, ++held;
    }
  }
  CHECK(held > 1000);
  CHECK(bounds > 0.975 * distances);
}

TEST_CASE("edges of two triangles in lanes are those of one pair at a time, bit for bit") {
  reference::Random random(5);
  const auto share = [](double over, double under) { return under > 0 ? std::clamp(over / under, 0.0, 1.0) : 0.0; };
  int parallel = 0, inner = 0;
  for (int n = 0; n < 3000; ++n) {
    Corners p, q;
    for (std::size_t k = 0; k < 3; ++k) p[k] = random.vec(-1, 1), q[k] = random.vec(-1, 1);
    if (n % 5 == 0) q[1] = q[0] + 2 * (p[1] - p[0]);  // one edge along another
    if (n % 7 == 0) q[2] = q[1];                      // an edge without length
    const PlacedTriangle a(p), b(q);
    EdgePairs found;
    nearest_on_edges(a.edges, b.edges, found);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        CAPTURE(n, i, j);
        const Vec3 d = a.edge(i), e = b.edge(j), r = p[i] - q[j];
        const double dd = d.squaredNorm(), ee = e.squaredNorm(), f = e.dot(r), c = d.dot(r), along = d.dot(e);
        const double det = dd * ee - along * along;
        double s = share(along * f - c * ee, det);
        const double t = share(along * s + f, ee);
        if (!(t > 0 && t < 1)) s = share(along * t - c, dd);
        CHECK(found.on_a[i][j] == s);
        CHECK(found.on_b[i][j] == t);
        CHECK(found.squared[i][j] == ((p[i] + s * d) - (q[j] + t * e)).squaredNorm());
        const bool crosses = det > tolerance::slanting2 * dd * ee;
        CHECK((found.parallel >> (4 * i + j) & 1u) == (crosses ? 0u : 1u));
        parallel += !crosses, inner += s > 0 && s < 1 && t > 0 && t < 1;
      }
  }
  CHECK(parallel > 500);
  CHECK(inner > 500);
}

TEST_CASE("distance of meshes of many kinds, sizes and places is the least of all their triangles") {
  reference::Random random(78);
  int apart = 0;
  for (int i = 0; i < 120; ++i) {
    const double scale = random.power_of_two(-20, 20),
                 other = random.once_in(2) ? scale : scale * random.power_of_two(-12, 0);
    const Shape a(soup(random, 1 + index(random, 40), scale)), b(soup(random, 1 + index(random, 40), other));
    const Vec3 far = i % 5 == 0 ? Vec3(1e5 * scale * random.direction()) : Vec3(0, 0, 0);
    const Pose pose_a{i % 3 == 0 ? Mat3(Mat3::Identity()) : random.rotation(), far};
    Pose pose_b{i % 3 == 0 ? Mat3(Mat3::Identity()) : random.rotation(), far};
    const Vec3 heading = random.direction();
    const auto touch = [&](double s) {
      pose_b.translation = far + s * heading;
      return NarrowPhase().solve(a, pose_a, b, pose_b, Request::collide).collide;
    };
    double low = 0, high = 8 * (scale + other);
    for (int k = 0; k < 30; ++k) (touch((low + high) / 2) ? low : high) = (low + high) / 2;
    if (touch(high + random.power_of_two(-30, 1) * scale)) continue;
    ++apart;
    const PairAnswer r = NarrowPhase().solve(a, pose_a, b, pose_b, Request::distance);
    CAPTURE(i);
    CHECK(std::abs(r.signed_distance - least_distance(a, pose_a, b, pose_b)) <=
          1e-14 * (a.size() + b.size() + far.norm()));
  }
  CHECK(apart > 100);
}

TEST_CASE("needles that are parallel but for rounding have their distance") {
  reference::Random random(80);
  const auto needles = [&] {
    Mesh mesh;
    for (std::uint32_t i = 0; i < 12; ++i) {
      const Vec3 middle = random.in(-1, 1) * Vec3::UnitX();
      const double length = random.power_of_two(-10, 0);
      for (int k = 0; k < 3; ++k)
        mesh.vertices.push_back(middle + (k == 1 ? length : 0) * Vec3::UnitX() + 1e-9 * random.vec(-1, 1));
      mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return Shape(mesh);
  };
  for (int i = 0; i < 400; ++i) {
    const Shape a = needles(), b = needles();
    const Pose pose_b = Pose::at(0, 0, random.in(0.01, 1));
    const PairAnswer r = NarrowPhase().solve(a, Pose{}, b, pose_b, Request::distance);
    CAPTURE(i);
    CHECK(std::abs(r.signed_distance - least_distance(a, Pose{}, b, pose_b)) < 1e-14);
  }
}

TEST_CASE("of a small mesh in a hollow one, whose triangles are nearly as far all round, the nearest is found") {
  reference::Random random(79);
  for (int i = 0; i < 6; ++i) {
    const Shape hollow(sphere(1.3, 8)), inner(i % 2 == 0 ? torus(0.02, 0.005, 12, 8) : sphere(1.1, 6));
    const Pose pose_a{random.rotation(), random.vec(-1, 1)};
    const Pose pose_b{random.rotation(), pose_a.translation + 0.01 * random.direction()};
    const PairAnswer r = NarrowPhase().solve(hollow, pose_a, inner, pose_b, Request::distance);
    CAPTURE(i);
    CHECK(std::abs(r.signed_distance - least_distance(hollow, pose_a, inner, pose_b)) < 1e-14);
  }
}

TEST_CASE("nearest points of meshes: where rounding parts two faces that rest on each other, the normal leads out") {
  reference::Random random(2026);
  int apart = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 half_a = random.vec(0.3, 1.5), half_b = random.vec(0.1, 1.5);
    const Shape a{box_mesh(2 * half_a, 1 + i % 3)}, b{box_mesh(2 * half_b)};
    const Pose at_a{random.rotation(), random.vec(-3, 3)};
    const double x = random.in(-0.5, 0.5) * half_a.x(), y = random.in(-0.5, 0.5) * half_a.y();
    const Pose at_b{at_a.rotation, at_a * Vec3(x, y, half_a.z() + half_b.z())};
    const Vec3 up = at_a.rotation.col(2);
    const PairAnswer answer = NarrowPhase().solve(a, at_a, b, at_b, Request::distance);
    CAPTURE(i, answer.signed_distance);
    apart += answer.collide ? 0 : 1;
    CHECK((answer.normal - up).norm() < 1e-9);
    // The patch of contacts within a margin needs that direction, too.
    std::vector<Contact> contacts;
    NarrowPhase({.margin = 1e-3}).solve(a, at_a, b, at_b, Request::contacts, &contacts);
    CHECK(contacts.size() >= 3);
    for (const Contact& c : contacts) CHECK((c.normal - up).norm() < 1e-9);
  }
  CHECK(apart > 100);
}

// Side by side, the tops in one plane: a pair of triangles there, a hair apart along parallel edges, has any direction.
TEST_CASE("nearest points of meshes: all nearest triangles decide on the direction, not one pair") {
  reference::Random random(2027);
  for (const double gap : {0.0, 1e-15, 1e-13, 1e-12, 1e-10, 1e-8, 1e-6})
    for (int i = 0; i < 300; ++i) {
      const Vec3 half_a = random.vec(0.5, 1.5);
      const Vec3 half_b = random.vec(0.25, 0.45);
      Mesh of_a = box_mesh(2 * half_a, 1 + i % 3), of_b = box_mesh(2 * half_b, 1 + i / 3 % 2);
      if (i % 2 != 0) of_a.solid = of_b.solid = false;
      const Shape a{of_a}, b{of_b};
      Pose at_a{random.rotation(), random.vec(-3, 3)};
      if (i % 4 == 0) at_a.translation *= 100;
      const double y = random.in(-0.3, 0.3);
      const Vec3 at(half_a.x() + half_b.x() + gap, y, half_a.z() - half_b.z());
      const Pose at_b{at_a.rotation, at_a * at};
      const Vec3 aside = at_a.rotation.col(0);
      CAPTURE(gap, i);
      CHECK((NarrowPhase().solve(a, at_a, b, at_b, Request::distance).normal - aside).norm() < 1e-12);
      std::vector<Contact> contacts;
      const PairAnswer answer = NarrowPhase({.margin = 1e-4}).solve(a, at_a, b, at_b, Request::contacts, &contacts);
      CHECK((answer.normal - aside).norm() < 1e-12);
      for (const Contact& c : contacts) CHECK((c.normal - aside).norm() < 1e-12);
    }
}

TEST_CASE("nearest points of meshes: triangles in both orientations on touching faces do not turn the direction") {
  reference::Random random(2028);
  const auto with_flaps = [&](Mesh mesh) {
    const std::vector<std::array<std::uint32_t, 3>> sides = mesh.triangles;
    for (const auto& t : sides)
      if (random.once_in(2)) mesh.triangles.push_back(t), mesh.triangles.push_back({t[0], t[2], t[1]});
    std::reverse(mesh.triangles.begin(), mesh.triangles.end());
    return mesh;
  };
  for (int i = 0; i < 300; ++i) {
    const Vec3 half_a = random.vec(0.5, 1.5), half_b = random.vec(0.25, 0.45);
    const Shape a{with_flaps(box_mesh(2 * half_a, 1 + i % 3))}, b{with_flaps(box_mesh(2 * half_b, 1 + i / 3 % 2))};
    const Pose at_a{random.rotation(), random.vec(-3, 3)};
    const double x = random.in(-0.2, 0.2), y = random.in(-0.2, 0.2);
    const Pose at_b{at_a.rotation, at_a * Vec3(x, y, half_a.z() + half_b.z() + 1e-15)};
    CAPTURE(i);
    CHECK((NarrowPhase().solve(a, at_a, b, at_b, Request::distance).normal - at_a.rotation.col(2)).norm() < 1e-12);
  }
}
