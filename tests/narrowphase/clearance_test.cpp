// Pairs of triangles within a clearance, their zones, and separations along a direction, each compared with brute
// force.
#include "tandem/narrowphase/clearance.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "catch.h"
#include "mesh_samples.h"
#include "narrowphase/random_pairs.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/work_limit.h"

using namespace tandem;
using namespace tandem::test;

namespace {

using Key = std::array<std::uint32_t, 2>;

Shape triangle_of(const Shape& mesh, std::uint32_t t) {
  const auto& c = mesh.triangles()[t];
  const auto v = mesh.vertices();
  return Triangle{{v[c[0]], v[c[1]], v[c[2]]}};
}

/// All against all, by the solver of single triangles.
std::map<Key, double> all_near(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b, double within) {
  const NarrowPhase narrow;
  std::map<Key, double> near;
  for (const Key& pair : narrow.intersecting_triangles(a, at_a, b, at_b)) near[pair] = 0;
  std::vector<Shape> of_a, of_b;
  for (std::uint32_t i = 0; i < a.triangles().size(); ++i) of_a.push_back(triangle_of(a, i));
  for (std::uint32_t j = 0; j < b.triangles().size(); ++j) of_b.push_back(triangle_of(b, j));
  for (std::uint32_t i = 0; i < of_a.size(); ++i)
    for (std::uint32_t j = 0; j < of_b.size(); ++j) {
      if (near.count({i, j}) != 0) continue;
      const double d = narrow.solve(of_a[i], at_a, of_b[j], at_b, Request::distance).signed_distance;
      if (d <= within) near[{i, j}] = std::max(d, 0.0);
    }
  return near;
}

std::map<Key, NearTriangles> visited(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b,
                                     double clearance) {
  std::map<Key, NearTriangles> found;
  double told = 0;
  NearOptions options{.clearance = clearance, .limit = nullptr, .progress = [&](double part) {
                        CHECK((part >= told && part <= 1));
                        told = part;
                      }};
  const SearchEnd end = visit_triangles(
      a, at_a, b, at_b,
      [&](const NearTriangles& near) {
        CHECK(found.emplace(near.triangles, near).second);
        return true;
      },
      options);
  CHECK(end == SearchEnd::done);
  if (!found.empty()) CHECK(told == 1);
  return found;
}

void check_against_all(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b, double clearance) {
  constexpr double doubt = 1e-9;
  const auto found = visited(a, at_a, b, at_b, clearance);
  const auto expected = all_near(a, at_a, b, at_b, clearance + doubt);
  for (const auto& [pair, near] : found) {
    const auto at = expected.find(pair);
    REQUIRE(at != expected.end());
    CHECK((near.distance == 0) == (at->second == 0));
    CHECK(std::abs(near.distance - at->second) < doubt);
    if (near.distance > 0) CHECK(std::abs((near.point_a - near.point_b).norm() - near.distance) < doubt);
  }
  for (const auto& [pair, distance] : expected)
    if (distance < clearance - doubt || distance == 0) CHECK(found.count(pair) == 1);
}

/// Components, each from one pair to all that are left.
std::vector<std::vector<Key>> all_zones(const Shape& a, const Shape& b, const std::map<Key, double>& near) {
  std::vector<Key> pairs;
  for (const auto& [pair, distance] : near) pairs.push_back(pair);
  const auto share = [](const Shape& s, std::uint32_t i, std::uint32_t j) {
    for (const std::uint32_t u : s.triangles()[i])
      for (const std::uint32_t v : s.triangles()[j])
        if (s.vertices()[u] == s.vertices()[v]) return true;
    return false;
  };
  std::vector<std::vector<Key>> out;
  while (!pairs.empty()) {
    std::vector<Key> zone{pairs.back()};
    pairs.pop_back();
    for (std::size_t i = 0; i < zone.size(); ++i)
      std::erase_if(pairs, [&](const Key& other) {
        if (!share(a, zone[i][0], other[0]) || !share(b, zone[i][1], other[1])) return false;
        zone.push_back(other);
        return true;
      });
    out.push_back(zone);
  }
  return out;
}

double area(const Shape& shape, const std::set<std::uint32_t>& triangles) {
  double sum = 0;
  for (const std::uint32_t t : triangles) {
    const auto v = triangle_of(shape, t);
    const auto p = v.vertices();
    sum += p.size() == 3 ? (p[1] - p[0]).cross(p[2] - p[0]).norm() / 2 : 0;
  }
  return sum;
}

void check_zones(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b, double clearance) {
  const auto near = all_near(a, at_a, b, at_b, clearance);
  const auto expected = all_zones(a, b, near);
  const auto zones = clearance_zones(a, at_a, b, at_b, {.clearance = clearance});
  REQUIRE(zones.size() == expected.size());
  double last = -std::numeric_limits<double>::infinity();
  for (const ClearanceZone& zone : zones) {
    CHECK(zone.signed_distance >= last);
    last = zone.signed_distance;
    const auto at = std::find_if(expected.begin(), expected.end(), [&](const std::vector<Key>& members) {
      return std::find(members.begin(), members.end(), zone.triangles) != members.end();
    });
    REQUIRE(at != expected.end());
    CHECK(zone.pairs == at->size());
    double least = std::numeric_limits<double>::infinity();
    std::size_t intersecting = 0;
    std::set<std::uint32_t> of_a, of_b;
    for (const Key& pair : *at) {
      least = std::min(least, near.at(pair));
      intersecting += near.at(pair) == 0 ? 1 : 0;
      of_a.insert(pair[0]), of_b.insert(pair[1]);
    }
    CHECK(zone.intersecting_pairs == intersecting);
    CHECK(std::abs(std::max(zone.signed_distance, 0.0) - least) < 1e-9);
    CHECK(std::abs(zone.area[0] - area(a, of_a)) < 1e-9);
    CHECK(std::abs(zone.area[1] - area(b, of_b)) < 1e-9);
    CHECK(std::abs(zone.normal.norm() - 1) < 1e-9);
    if (zone.signed_distance > 1e-6)
      CHECK((zone.point_b - zone.point_a - zone.signed_distance * zone.normal).norm() < 1e-9);
    const Vec3 middle = (zone.point_a + zone.point_b) / 2;
    if (zone.signed_distance > 0)
      CHECK(((middle - zone.bounds.lo).minCoeff() >= -1e-9 && (zone.bounds.hi - middle).minCoeff() >= -1e-9));
  }
}

/// A table with four legs, each a separate box, over a floor of two triangles at z = 0.
Mesh table(double gap) {
  Mesh legs;
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      const Mesh leg = box_mesh({0.2, 0.2, 1}, 1);
      const auto first = static_cast<std::uint32_t>(legs.vertices.size());
      for (const Vec3& v : leg.vertices) legs.vertices.push_back(v + Vec3(x, y, 0.5 + gap * (1.5 + x / 2)));
      for (auto t : leg.triangles) legs.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  legs.solid = true;
  return legs;
}

const Shape& floor_sheet() {
  static const Shape sheet{Mesh{{{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}}, {{0, 1, 2}, {0, 2, 3}}, false}};
  return sheet;
}

}  // namespace

TEST_CASE("clearance: every pair of triangles within it is visited once, as all against all has it") {
  Random random(5);
  const Shape ring{torus(1, 0.4, 12, 8)}, small{torus(0.7, 0.3, 9, 7)}, cube{box_mesh({1, 1.2, 0.9}, 2)};
  const Shape sheet = floor_sheet();
  std::size_t near = 0;
  for (int i = 0; i < 4; ++i) {
    const Pose at_a = random_pose(random, 1), at_b = random_pose(random, 1);
    for (const double clearance : {0.0, 0.15}) {
      CAPTURE(i, clearance);
      check_against_all(ring, at_a, small, at_b, clearance);
      check_against_all(cube, at_a, small, at_b, clearance);
      check_against_all(cube, at_a, sheet, at_b, clearance);
      near += visited(ring, at_a, small, at_b, clearance).size();
    }
  }
  CHECK(near > 100);
  check_against_all(cube, {}, cube, Pose::at(1, 0, 0), 0);    // flush
  check_against_all(cube, {}, cube, Pose::at(1, 0, 0), 0.1);  // and near
  check_against_all(cube, {}, cube, {}, 0);
}

TEST_CASE("clearance: a visitor ends the search, so does the limit, and what a visitor throws is its own") {
  const Shape ring{torus(1, 0.4, 60, 40)}, small{torus(0.8, 0.3, 50, 40)};
  const Pose at = Pose::at(0.5, 0.2, 0.1);
  for (const double clearance : {0.0, 0.05}) {
    std::size_t count = 0;
    const auto first_seven = [&](const NearTriangles&) { return ++count < 7; };
    CHECK(visit_triangles(ring, {}, small, at, first_seven, {.clearance = clearance}) == SearchEnd::by_visitor);
    CHECK(count == 7);
    const std::size_t all = visited(ring, {}, small, at, clearance).size();
    REQUIRE(all > 300);
    int looks = 0;
    WorkLimit limit;
    limit.ended = [&] { return ++looks > 4; };
    count = 0;
    const auto every = [&](const NearTriangles&) { return ++count, true; };
    CHECK(visit_triangles(ring, {}, small, at, every, {.clearance = clearance, .limit = &limit}) == SearchEnd::stopped);
    CHECK(count < all);
    looks = 0;
    CHECK_THROWS_AS(clearance_zones(ring, {}, small, at, {.clearance = clearance, .limit = &limit}), WorkStopped);
    const auto throws = [](const NearTriangles&) -> bool { throw WorkStopped(); };
    CHECK_THROWS_AS(visit_triangles(ring, {}, small, at, throws, {.clearance = clearance}), WorkStopped);
  }
}

TEST_CASE("clearance: what intersects is streamed as the list has it") {
  const Shape ring{torus(1, 0.4, 80, 50)}, small{torus(0.8, 0.3, 60, 40)};
  for (const double x : {0.1, 0.9, 1.9, 3.0}) {
    const Pose at = Pose::from(Quat(0.9, 0.1, 0.3, 0.2), {x, 0.1, 0.2});
    std::vector<Key> streamed;
    visit_triangles(small, at, ring, {}, [&](const NearTriangles& near) {
      streamed.push_back(near.triangles);
      return true;
    });
    std::sort(streamed.begin(), streamed.end());
    CHECK(streamed == NarrowPhase().intersecting_triangles(small, at, ring, {}));
  }
}

TEST_CASE("clearance: zones are the components that comparing all pairs has") {
  Random random(8);
  const Shape ring{torus(1, 0.4, 12, 8)}, rod{box_mesh({4, 0.15, 0.15}, 4)}, cube{box_mesh({1, 1.2, 0.9}, 2)};
  std::size_t several = 0;
  for (int i = 0; i < 4; ++i) {
    const Pose at_a = random_pose(random, 0.3), at_b = random_pose(random, 0.3);
    for (const double clearance : {0.0, 0.04}) {
      CAPTURE(i, clearance);
      check_zones(rod, at_a, ring, at_b, clearance);
      check_zones(cube, at_a, ring, at_b, clearance);
      several += clearance_zones(rod, at_a, ring, at_b, {.clearance = clearance}).size() > 1 ? 1 : 0;
    }
  }
  CHECK(several > 3);
}

TEST_CASE("clearance: four feet near a floor of two triangles are four zones with their places") {
  const Shape legs{table(0.01)};
  const auto zones = clearance_zones(legs, {}, floor_sheet(), {}, {.clearance = 0.05});
  REQUIRE(zones.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const ClearanceZone& zone = zones[i];
    CHECK(std::abs(zone.signed_distance - (i < 2 ? 0.01 : 0.02)) < 1e-12);
    CHECK((zone.normal - Vec3(0, 0, -1)).norm() < 1e-12);
    CHECK(zone.bounds.hi.x() - zone.bounds.lo.x() < 0.2 + 1e-12);
    CHECK(std::abs(std::abs(zone.point_a.x()) - 1) < 0.1 + 1e-12);
    CHECK(zone.intersecting_pairs == 0);
  }
  const auto sunk = clearance_zones(legs, Pose::at(0, 0, -0.015), floor_sheet(), {}, {.clearance = 0.05});
  REQUIRE(sunk.size() == 4);
  CHECK(sunk[0].signed_distance < 0);
  CHECK(sunk[0].signed_distance >= -0.005 - 1e-12);
  CHECK(sunk[0].intersecting_pairs > 0);
  CHECK(sunk[3].signed_distance > 0);
  CHECK(clearance_zones(legs, Pose::at(0, 0, 1), floor_sheet(), {}, {.clearance = 0.05}).empty());
}

TEST_CASE("clearance: bad input is refused by name") {
  const Shape cube{box_mesh({1, 1, 1}, 1)}, ball = Sphere{1};
  const auto every = [](const NearTriangles&) { return true; };
  CHECK_THROWS_AS(visit_triangles(cube, {}, ball, {}, every), std::invalid_argument);
  CHECK_THROWS_AS(visit_triangles(cube.rounded(0.1), {}, cube, {}, every), std::invalid_argument);
  for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    CHECK_THROWS_AS(visit_triangles(cube, {}, cube, {}, every, {.clearance = bad}), std::invalid_argument);
  CHECK_THROWS_AS(visit_triangles(cube, Pose::at(std::nan(""), 0, 0), cube, {}, every), std::invalid_argument);
  for (const Vec3& bad : {Vec3(0, 0, 0), Vec3(1, std::nan(""), 0)})
    CHECK_THROWS_AS(separation_along(cube, {}, ball, {}, bad), std::invalid_argument);
  const Shape half = HalfSpace{{0, 0, 1}, 0};
  CHECK_THROWS_AS(separation_along(half, {}, half, {}, Vec3(0, 0, 1)), std::invalid_argument);
}

namespace {

/// At the distance they just touch or are separated, before it they touch, beyond it never again.
void check_separation(const Shape& a, const Pose& at_a, const Shape& b, const Pose& at_b, const Vec3& direction) {
  const NarrowPhase narrow;
  const double t = separation_along(a, at_a, b, at_b, direction), size = a.size() + b.size();
  const auto collide = [&](double shift) {
    const Pose moved{at_b.rotation, at_b.translation + shift * direction.normalized()};
    return narrow.solve(a, at_a, b, moved, Request::collide).collide;
  };
  CAPTURE(a.kind(), b.kind(), t);
  REQUIRE(std::isfinite(t));
  CHECK(!collide(t + 1e-9 * size));
  if (t > 0) CHECK(collide(t - 1e-6 * size));
  for (int i = 1; i <= 200; ++i)
    if (const double shift = t + 1e-9 * size + i * (2 * size / 200); collide(shift))
      FAIL_CHECK("touches again at " << shift);
}

}  // namespace

TEST_CASE("separation along a direction: they touch until there and never again, by yes and no") {
  Random random(17);
  const std::vector<Shape> solids{Shape{Box{{1, 0.7, 0.5}}},     Shape{Sphere{0.6}},
                                  Shape{Capsule{0.3, 1}},        Shape{Cylinder{0.4, 1}},
                                  Shape{box_mesh({1, 1, 1}, 2)}, Shape{torus(0.8, 0.3, 24, 16)},
                                  Shape{Cone{0.5, 1}},           Shape{Box{{0.5, 0.4, 0.3}}}.rounded(0.2)};
  int touching = 0;
  for (int i = 0; i < 40; ++i) {
    const auto any = [&] { return static_cast<std::size_t>(random.below(static_cast<int>(solids.size()))); };
    const Shape &a = solids[any()], &b = solids[any()];
    const Pose at_a = random_pose(random, 0.3), at_b = random_pose(random, 0.3);
    const Vec3 direction = 3 * random.direction();
    check_separation(a, at_a, b, at_b, direction);
    touching += separation_along(a, at_a, b, at_b, direction) > 0 ? 1 : 0;
  }
  CHECK(touching > 30);
}

TEST_CASE("separation along a direction: an advance that ends where B stands is no touch by itself") {
  Mesh square{{{-1, -1, 0}, {-1, 1, 0}, {1, -1, 0}, {1, 1, 0}}, {{0, 2, 3}, {0, 3, 1}}, false};
  Pose at_square, at_triangle = Pose::at(-0.625, -0.125, 1.25);
  at_square.rotation << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  at_triangle.rotation << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  const Shape triangle(Triangle{{Vec3(-0.25, -0.125, 0.625), Vec3(0.625, 0.75, 0.625), Vec3(0.25, 0.375, 0.125)}});
  // They are 0.2 apart, and the last plane between them is reached at the end of the translation, except for its last
  // bits.
  CHECK(separation_along(Shape(square), at_square, triangle, at_triangle,
                         {-0.33384970903780736, 0.50601770021838899, -0.79529268753149251}) == 0);
}

TEST_CASE("separation along a direction: of boxes, of what lies inside, of a ring, of half-spaces") {
  const Shape block{box_mesh({2, 2, 2}, 2)}, small{box_mesh({0.2, 0.2, 0.2}, 1)}, ring{torus(1, 0.25, 48, 24)};
  const auto along = [](const Shape& a, const Shape& b, const Pose& at, const Vec3& d) {
    return separation_along(a, {}, b, at, d);
  };
  CHECK(std::abs(along(Box{{2, 2, 2}}, Box{{1, 1, 1}}, Pose::at(1.2, 0, 0), {1, 0, 0}) - 0.3) < 1e-12);
  CHECK(std::abs(along(Box{{2, 2, 2}}, Box{{1, 1, 1}}, Pose::at(1.2, 0, 0), {-5, 0, 0}) - 2.7) < 1e-12);
  CHECK(std::abs(along(block, small, Pose::at(0.3, 0, 0), {0, 0, 2}) - 1.1) < 1e-12);  // from inside
  CHECK(std::abs(along(block, small, Pose::at(-4, 0, 0), {1, 0, 0}) - 5.1) < 1e-12);   // apart, and in the path
  CHECK(along(block, small, Pose::at(4, 0, 0), {1, 0, 0}) == 0);
  CHECK(along(block, small, Pose::at(0, 4, 0), {1, 0, 0}) == 0);
  CHECK(along(ring, small, Pose::at(0, 0, 0), {0, 0, 1}) == 0);  // through the hole
  // From one side of the ring out through the other: the last contact counts.
  const double through = along(ring, small, Pose::at(-1, 0, 0), {1, 0, 0});
  CHECK((through > 2.34 && through < 2.36));
  const Shape ground = HalfSpace{{0, 0, 1}, 0};
  CHECK(std::abs(along(ground, small, Pose::at(0, 0, -0.4), {0, 3, 4}) - 0.5 / 0.8) < 1e-12);
  CHECK(std::abs(separation_along(small, Pose::at(0, 0, -0.4), ground, {}, {0, 0, -1}) - 0.5) < 1e-12);
  CHECK(std::isinf(along(ground, small, Pose::at(0, 0, -0.4), {0, 0, -1})));
  CHECK(std::isinf(along(ground, small, Pose::at(0, 0, 5), {0, 0, -1})));
  CHECK(along(ground, small, Pose::at(0, 0, 5), {1, 0, 0}) == 0);
  WorkLimit limit;
  limit.deadline = std::chrono::steady_clock::now();
  CHECK_THROWS_AS(separation_along(ring, {}, small, Pose::at(1, 0, 0), {1, 0, 0}, {.limit = &limit}), WorkStopped);
}
