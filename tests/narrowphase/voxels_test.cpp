// Voxels: every request against all cells as boxes, one by one.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "catch.h"
#include "mesh_samples.h"
#include "random_pairs.h"
#include "tandem/narrowphase/motion.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/penetration.h"
#include "tandem/narrowphase/shape_makers.h"
#include "tandem/narrowphase/work_limit.h"

using namespace tandem;
using namespace tandem::test;

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

/// A cell of the shape as a box, and where it stands.
struct CellBox {
  Shape box = Sphere{0};
  Pose pose;
};

std::vector<CellBox> boxes_of(const Shape& voxels, const Pose& pose) {
  std::vector<CellBox> boxes;
  for (const VoxelCell& cell : voxels.cells()) {
    const double edge = voxels.cell_size() * (1 << cell.level);
    const Vec3 corner = voxels.origin() + voxels.cell_size() * Vec3(cell.corner[0], cell.corner[1], cell.corner[2]);
    const Shape box = Box{Vec3::Constant(edge)};
    boxes.push_back({voxels.rounding() > 0 ? box.rounded(voxels.rounding()) : box,
                     {pose.rotation, pose * Vec3(corner + Vec3::Constant(edge / 2))}});
  }
  return boxes;
}

/// A few large clusters of small cells with larger ones among them.
Shape random_voxels(Random& r, int count) {
  Voxels v;
  v.cell_size = r.in(0.03, 0.2);
  v.origin = r.vec(-1, 1);
  for (int i = 0; i < count; ++i) {
    const auto level = static_cast<std::uint8_t>(i % 7 == 0 ? 2 : i % 3 == 0 ? 1 : 0);
    const auto place = [&] { return (static_cast<std::int32_t>(std::floor(r.in(-8, 8))) >> level) << level; };
    v.cells.push_back({{place(), place(), place()}, level});
  }
  return Shape(v);
}

/// The least signed distance of any cell; more than one may be that.
double brute_distance(const std::vector<CellBox>& cells, const Shape& other, const Pose& pose) {
  const NarrowPhase n;
  double least = infinite;
  for (const CellBox& cell : cells)
    least = std::min(least, n.solve(cell.box, cell.pose, other, pose, Request::distance).signed_distance);
  return least;
}
/// A lower bound on the depth of the deepest cell.
double brute_depth(const std::vector<CellBox>& cells, const Shape& other, const Pose& pose) {
  const NarrowPhase n;
  double most = 0;
  for (const CellBox& cell : cells) {
    const PairAnswer answer = n.solve(cell.box, cell.pose, other, pose, Request::distance);
    most = std::max(most, -answer.signed_distance - answer.error_bound);
  }
  return most;
}

Pose moved(Pose pose, const Vec3& by) {
  pose.translation += by;
  return pose;
}

}  // namespace

TEST_CASE("voxels with every kind: verdict, distance, depth and cut-off are those of all cells") {
  Random r(401);
  const NarrowPhase n;
  for (std::size_t k = 0; k < shape_kinds; ++k) {
    int hits = 0, misses = 0, proven = 0;
    for (int i = 0; i < 60; ++i) {
      Shape voxels = random_voxels(r, 1 + i), other = random_shape(static_cast<ShapeKind>(k), r);
      if (i % 5 == 4) voxels = voxels.rounded(0.05);
      if (i % 7 == 6) other = other.rounded(0.08);
      const Pose at = random_pose(r, 0.5), pose = random_pose(r, i % 2 == 0 ? 0.7 : 2);
      CAPTURE(name(other.kind()), i);
      const auto cells = boxes_of(voxels, at);
      const double least = brute_distance(cells, other, pose);
      const PairAnswer answer = n.solve(voxels, at, other, pose, Request::distance);
      REQUIRE(answer.collide == (least <= 0));
      CHECK(n.solve(voxels, at, other, pose, Request::collide).collide == answer.collide);
      CHECK(n.solve(other, pose, voxels, at, Request::collide).collide == answer.collide);
      CHECK(std::abs(answer.normal.norm() - 1) < 1e-9);
      const PairAnswer back = n.solve(other, pose, voxels, at, Request::distance);
      CHECK(back.signed_distance == answer.signed_distance);
      CHECK(back.point_a == answer.point_b);
      CHECK(back.normal == Vec3(-answer.normal));
      (answer.collide ? hits : misses) += 1;
      if (least > 0) {
        CHECK(std::abs(answer.signed_distance - least) < 1e-12);
        CHECK((answer.point_b - answer.point_a - answer.signed_distance * answer.normal).norm() < 1e-7);
      } else {
        const double certain = brute_depth(cells, other, pose);
        CHECK(-answer.signed_distance >= certain - 1e-11);
        CHECK(-answer.signed_distance - answer.error_bound <= certain + 1e-11);
        CHECK((answer.status == Status::ok) == (answer.error_bound == 0));
        proven += answer.status == Status::ok;
        // A longer translation may end at the other side of a notch.
        const Pose out = moved(pose, (1e-12 - answer.signed_distance) * answer.normal);
        const PairAnswer left = n.solve(voxels, at, other, out, Request::distance);
        CHECK(left.signed_distance + left.error_bound >= -2e-11);
      }
      for (const double cutoff : {0.0, 0.7 * std::max(least, 0.0), 1.5 * std::max(least, 0.0) + 0.1}) {
        const PairAnswer within = n.distance_within(voxels, at, other, pose, cutoff);
        REQUIRE(within.farther == (answer.signed_distance > cutoff));
        if (!within.farther) CHECK(within.signed_distance == answer.signed_distance);
        if (!within.farther) CHECK(within.point_a == answer.point_a);
      }
    }
    CAPTURE(name(static_cast<ShapeKind>(k)));
    CHECK(hits > 5);
    CHECK(misses > 5);
    CHECK(proven > 0);
  }
}

TEST_CASE("voxels with every kind: contacts within the margin are there, as deep as cells, on surfaces") {
  Random r(402);
  for (const double margin : {0.0, 0.15}) {
    NarrowPhaseOptions options;
    options.margin = margin;
    const NarrowPhase n(options);
    for (std::size_t k = 0; k < shape_kinds; ++k) {
      int found = 0;
      for (int i = 0; i < 40; ++i) {
        Shape voxels = random_voxels(r, 1 + i), other = random_shape(static_cast<ShapeKind>(k), r);
        if (i % 5 == 4) voxels = voxels.rounded(0.05);
        const Pose at = random_pose(r, 0.5), pose = random_pose(r, i % 2 == 0 ? 0.7 : 1.5);
        CAPTURE(name(other.kind()), i, margin);
        const PairAnswer whole = n.solve(voxels, at, other, pose, Request::distance);
        std::vector<Contact> contacts, exchanged;
        const PairAnswer answer = n.solve(voxels, at, other, pose, Request::contacts, &contacts);
        CHECK(answer.collide == whole.collide);
        if (std::abs(whole.signed_distance - margin) < 1e-9) continue;
        REQUIRE(contacts.empty() == (whole.signed_distance > margin));
        if (contacts.empty()) continue;
        ++found;
        double deepest = -infinite;
        for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
        CHECK(std::abs(deepest + answer.signed_distance) < 1e-12);
        // No deeper than what separates, and what the bound says is kept.
        CHECK(deepest <= -whole.signed_distance + 1e-11);
        CHECK(deepest + answer.error_bound >= -whole.signed_distance - whole.error_bound - 1e-11);
        if (!whole.collide) CHECK(std::abs(deepest + whole.signed_distance) < 1e-11);
        for (std::size_t c = 1; c < contacts.size(); ++c) CHECK(contacts[c - 1].feature <= contacts[c].feature);
        const PairAnswer back = n.solve(other, pose, voxels, at, Request::contacts, &exchanged);
        CHECK(back.signed_distance == answer.signed_distance);
        REQUIRE(exchanged.size() == contacts.size());
        for (std::size_t c = 0; c < contacts.size(); ++c) CHECK(exchanged[c].point == contacts[c].point);
        if (answer.status == Status::ok && whole.collide) {
          const Pose out = moved(pose, (1e-9 - answer.signed_distance) * answer.normal);
          CHECK_FALSE(n.solve(voxels, at, other, out, Request::collide).collide);
        }
      }
      CAPTURE(name(static_cast<ShapeKind>(k)));
      CHECK(found > 5);
    }
  }
}

TEST_CASE("voxels: the first touch is that of the cell which is met first, straight and turning") {
  Random r(403);
  const NarrowPhase n;
  int met = 0, missed = 0;
  for (std::size_t k = 0; k < shape_kinds; ++k)
    for (int i = 0; i < 12; ++i) {
      Shape voxels = random_voxels(r, 1 + 2 * i);
      if (i % 4 == 3) voxels = voxels.rounded(0.05);
      const Shape other = random_shape(static_cast<ShapeKind>(k), r);
      const Pose at = random_pose(r, 0.5), from = random_pose(r, 3), to = random_pose(r, 3);
      const auto cells = boxes_of(voxels, at);
      CAPTURE(name(other.kind()), i);
      const Vec3 towards = r.in(-1, 1) * from.translation, velocity = towards + r.vec(-1, 1);
      double first = infinite;
      for (const CellBox& cell : cells)
        if (const auto t = n.time_of_impact(cell.box, cell.pose, Vec3::Zero(), other, from, velocity, 2))
          first = std::min(first, *t);
      const auto t = n.time_of_impact(voxels, at, Vec3::Zero(), other, from, velocity, 2);
      const auto back = n.time_of_impact(other, from, velocity, voxels, at, Vec3::Zero(), 2);
      REQUIRE(t.has_value() == (first < infinite));
      REQUIRE(back.has_value() == t.has_value());
      if (t) CHECK(std::abs(*t - first) < 1e-9);
      if (t) CHECK(std::abs(*back - first) < 1e-9);
      (t ? met : missed) += 1;
      double turning = infinite;
      const Motion motion{from, to};
      for (const CellBox& cell : cells)
        if (const auto touch = n.time_of_impact(cell.box, Motion{cell.pose, cell.pose}, other, motion))
          turning = std::min(turning, touch->t);
      const auto touch = n.time_of_impact(voxels, Motion{at, at}, other, motion);
      REQUIRE(touch.has_value() == (turning < infinite));
      if (touch) CHECK(std::abs(touch->t - turning) < 1e-6);
    }
  CHECK(met > 20);
  CHECK(missed > 20);
}

TEST_CASE("voxels: one set of points is one shape, however it is cut into cells") {
  Random r(404);
  for (int i = 0; i < 30; ++i) {
    const Shape whole = random_voxels(r, 40);
    Voxels cut{{}, whole.cell_size(), whole.origin()};
    double cubes = 0;
    for (const VoxelCell& cell : whole.cells()) {
      const std::int32_t edge = 1 << cell.level;
      for (std::int32_t at = 0; at < edge * edge * edge; ++at, ++cubes)
        cut.cells.push_back(
            {{cell.corner[0] + at % edge, cell.corner[1] + at / edge % edge, cell.corner[2] + at / edge / edge}, 0});
    }
    std::reverse(cut.cells.begin(), cut.cells.end());
    cut.cells.push_back(cut.cells.front());
    const Shape again(cut);
    REQUIRE(std::equal(whole.cells().begin(), whole.cells().end(), again.cells().begin(), again.cells().end()));
    const double cell = std::pow(whole.cell_size(), 3);
    CHECK(again.mass().volume == Approx(cubes * cell).epsilon(1e-12));
    // As the mesh of the same cells, whose corner is at the origin.
    std::vector<std::array<std::int32_t, 3>> corners;
    for (const VoxelCell& c : cut.cells) corners.push_back(c.corner);
    const Shape mesh = voxel_mesh(corners, whole.cell_size());
    CHECK((mesh.mass().centre + whole.origin() - again.mass().centre).norm() < 1e-11);
    CHECK((mesh.mass().inertia - again.mass().inertia).norm() < 1e-11 * again.mass().inertia.norm());
    const Pose pose = random_pose(r, 2);
    const Pose of_mesh{pose.rotation, pose * whole.origin()};
    const Bounds exact = mesh.bounds(of_mesh), bounds = again.bounds(pose);
    CHECK((bounds.lo - exact.lo).norm() < 1e-12);
    CHECK((bounds.hi - exact.hi).norm() < 1e-12);
    CHECK(again.size() == Approx(mesh.size()).epsilon(1e-12));
    const Pose ball = random_pose(r, 3);
    const NarrowPhase n;
    const double d = n.solve(mesh, of_mesh, Sphere{0.1}, ball, Request::distance).signed_distance;
    if (d > 0)
      CHECK(n.solve(again, pose, Sphere{0.1}, ball, Request::distance).signed_distance == Approx(d).margin(1e-12));
  }
}

TEST_CASE("voxels: cells become larger ones only where all eight are there") {
  // Eight entries that begin and end as eight octants do, one octant empty and another of two small cells.
  Voxels v{{{{2, 0, 0}, 0}, {{3, 0, 0}, 0}}, 1};
  for (const std::int32_t octant : {0, 2, 3, 4, 5, 7})
    v.cells.push_back({{(octant & 1) * 2, (octant >> 1 & 1) * 2, (octant >> 2) * 2}, 1});
  CHECK(Shape(v).mass().volume == Approx(50));
  Random r(407);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::uint8_t> there(16 * 16 * 16, 0);
    for (std::size_t c = 0; c < there.size(); c += 8) {
      const std::size_t x = c % 16, y = c / 16 % 16, z = c / 256;
      const bool block = ((x / 4 * 7 + y / 4 * 5 + z / 4 * 3 + static_cast<std::size_t>(i)) % 3) != 0;
      for (std::size_t k = 0; k < 8; ++k) there[c + k] = block != (r.in(0, 1) < 0.02);
    }
    const auto count = static_cast<double>(std::count(there.begin(), there.end(), 1));
    CHECK(occupancy_grid(there, {16, 16, 16}, 1).mass().volume == Approx(count));
  }
}

TEST_CASE("voxels: a ball over the edge between two cells of a floor is pushed straight up") {
  const Shape floor(Voxels{{{{0, 0, 0}, 1}, {{2, 0, 0}, 1}}, 0.5});
  std::vector<Contact> contacts;
  NarrowPhase().solve(floor, {}, Sphere{0.3}, Pose::at(1.1, 0.5, 1.25), Request::contacts, &contacts);
  CHECK(contacts.size() == 1);
  for (const Contact& c : contacts) CHECK(c.normal.z() == Approx(1));
}

TEST_CASE("voxels: what lies flat on a floor of cells is pushed up, not off the edges between them") {
  std::vector<std::uint8_t> floor(20 * 20 * 2, 1);
  const Shape ground = occupancy_grid(floor, {20, 20, 2}, 0.1, Vec3(-1, -1, -0.2));
  CHECK(ground.cells().size() < 20 * 20);
  const NarrowPhase n({.margin = 0.001});
  Random r(405);
  for (int i = 0; i < 40; ++i) {
    const double sunk = i % 4 == 0 ? 0 : r.in(0.001, 0.03);
    const Shape box = Box{{0.6, 0.4, 0.2}};
    Pose pose{Mat3::Identity(), {r.in(-0.5, 0.5), r.in(-0.5, 0.5), 0.1 - sunk}};
    pose.rotation = Eigen::AngleAxisd(i % 3 == 0 ? 0 : r.in(0, 3), Vec3::UnitZ()).toRotationMatrix();
    std::vector<Contact> contacts;
    const PairAnswer answer = n.solve(ground, Pose{}, box, pose, Request::contacts, &contacts);
    CAPTURE(i, sunk);
    CHECK(answer.status == Status::ok);
    CHECK(answer.signed_distance == Approx(-sunk).margin(1e-12));
    CHECK(contacts.size() == 4);
    for (const Contact& c : contacts) {
      CHECK(c.normal.z() == Approx(1));
      CHECK(c.depth == Approx(sunk).margin(1e-12));
    }
  }
}

TEST_CASE("voxels: one cell, touching, far out, tiny and huge") {
  const NarrowPhase n;
  for (const double size : {0x1p-66, 0x1p-10, 1.0, 0x1p50})
    for (const double far : {0.0, 0x1p20}) {
      CAPTURE(size, far);
      const std::vector<std::array<std::int32_t, 3>> one{{0, 0, 0}};
      const Shape cell = voxels(one, size);
      CHECK(cell.cells().size() == 1);
      const Shape box = Box{Vec3::Constant(size)};
      const Vec3 out = far * size * Vec3(1, 2, 3);
      const auto at = [&](double x) { return Pose{Mat3::Identity(), out + size * Vec3(x, 0.5, 0.5)}; };
      const Pose here{Mat3::Identity(), out};
      CHECK(n.solve(cell, here, box, at(1.5), Request::collide).collide);
      CHECK_FALSE(n.solve(cell, here, box, at(1.5 + 1e-6), Request::collide).collide);
      CHECK(n.solve(cell, here, box, at(2), Request::distance).signed_distance == Approx(size / 2).epsilon(1e-8));
      CHECK(n.solve(cell, here, box, at(1.25), Request::distance).signed_distance == Approx(-size / 4).epsilon(1e-8));
      std::vector<Contact> contacts;
      n.solve(cell, here, box, at(1.25), Request::contacts, &contacts);
      CHECK(contacts.size() == 4);
    }
  // Cells as far from each other as a grid allows.
  const std::int32_t end = 1 << 20;
  const Shape ends(Voxels{{{{-end, -end, -end}, 0}, {{end - 1, end - 1, end - 1}, 0}, {{0, 0, 0}, 19}}, 0.5});
  CHECK(ends.cells().size() == 3);
  CHECK(ends.bounds({}).lo == Vec3::Constant(-0.5 * end));
  CHECK(ends.bounds({}).hi == Vec3::Constant(0.5 * end));
  CHECK(n.solve(ends, {}, Sphere{1}, Pose::at(-0.5 * end, -0.5 * end, -0.5 * end), Request::collide).collide);
  CHECK_FALSE(n.solve(ends, {}, Sphere{1}, Pose::at(-2, -2, -2), Request::collide).collide);
  const Shape all(Voxels{{{{-end, 0, 0}, 20}, {{0, 0, -end}, 20}}, 1});
  CHECK(all.cells().size() == 2);
}

TEST_CASE("voxels: bad input is refused by name") {
  const auto refused = [](const Voxels& v, const std::string& word) {
    CHECK_THROWS_WITH(Shape(v), Catch::Matchers::Contains("voxels") && Catch::Matchers::Contains(word));
  };
  const double nan = std::nan("");
  refused({{}, 1}, "cells is empty");
  for (const double size : {0.0, -1.0, nan, infinite, 1e-40, 1e31}) refused({{{{0, 0, 0}, 0}}, size}, "cell_size");
  for (const double at : {nan, infinite, 1e10}) refused({{{{0, 0, 0}, 0}}, 1, Vec3(0, at, 0)}, "origin[1]");
  refused({{{{0, 0, 0}, 0}, {{0, 0, 1 << 20}, 0}}, 1}, "cells[1]");
  refused({{{{0, -(1 << 20) - 1, 0}, 0}}, 1}, "cells[0]");
  refused({{{{1, 0, 0}, 1}}, 1}, "multiple of 2");
  refused({{{{0, 1 << 19, 0}, 0}}, 1e29}, "farthest coordinate");
  refused({{{{-1, 0, 0}, 0}, {{0, 0, 0}, 0}}, 9e29}, "width of all cells");
  refused({{{{0, 0, 0}, 21}}, 1}, "level");
  refused({{{{std::numeric_limits<std::int32_t>::max(), 0, 0}, 0}}, 1}, "cells[0]");
  refused({{{{0, 0, std::numeric_limits<std::int32_t>::min()}, 3}}, 1}, "cells[0]");
  const std::vector<std::uint8_t> none(8, 0), some(8, 1);
  CHECK_THROWS_AS(occupancy_grid(none, {2, 2, 2}, 1), std::invalid_argument);
  CHECK_THROWS_WITH(occupancy_grid(some, {2, 2, 3}, 1), Catch::Matchers::Contains("number of values"));
  CHECK_THROWS_WITH(occupancy_grid(some, {0, 2, 2}, 1), Catch::Matchers::Contains("count[0]"));
  CHECK_THROWS_AS(voxels({}, 1), std::invalid_argument);
}

TEST_CASE("voxels: two sets of cells, depths by penetration_depth, memory") {
  Random r(406);
  const NarrowPhase n;
  int hits = 0;
  for (int i = 0; i < 80; ++i) {
    const Shape a = random_voxels(r, 10 + i), b = random_voxels(r, 30);
    const Pose pa = random_pose(r, 1), pb = random_pose(r, 1.5);
    double least = infinite;
    for (const CellBox& cell : boxes_of(a, pa))
      least = std::min(least, brute_distance(boxes_of(b, pb), cell.box, cell.pose));
    const PairAnswer answer = n.solve(a, pa, b, pb, Request::distance);
    CAPTURE(i, least);
    CHECK(answer.collide == (least <= 0));
    if (least > 0) {
      CHECK(std::abs(answer.signed_distance - least) < 1e-12);
      continue;
    }
    ++hits;
    const DepthBounds bounds = penetration_depth(a, pa, b, pb);
    CHECK(bounds.lower <= bounds.upper);
    CHECK(bounds.lower == Approx(-least).epsilon(1e-9));
    CHECK_FALSE(n.solve(a, pa, b, moved(pb, bounds.translation), Request::collide).collide);
  }
  CHECK(hits > 20);
  std::vector<std::array<std::int32_t, 3>> sheet;
  for (std::int32_t i = 0; i < 40000; ++i) sheet.push_back({i % 200, i / 200, (i * 7 % 11) * 2});
  const Shape wide = voxels(sheet, 0.05);
  CHECK(wide.cells().size() == sheet.size());
  CHECK(wide.memory() < 24 * sheet.size());
}

TEST_CASE("voxels: what sinks into a floor beside an edge between cells is pushed up, held at both its ends") {
  // Each cell by itself pushes it sideways into the next one.
  const std::vector<std::uint8_t> all(36, 1);
  const Shape floor = occupancy_grid(all, {6, 6, 1}, 1, Vec3(-3, -3, 0));
  Pose lying = Pose::at(0.95, 0.1, 0.9);
  lying.rotation = Eigen::AngleAxisd(std::acos(-1) / 2, Vec3::UnitX()).toRotationMatrix();
  const Shape capsule = Capsule{0.3, 2}, box = Box{{0.2, 2, 0.2}};
  for (const bool bounds : {true, false}) {
    CAPTURE(bounds);
    const NarrowPhase n({.margin = 0.001, .mesh_bounds = bounds});
    std::vector<Contact> contacts;
    const PairAnswer answer = n.solve(floor, {}, capsule, lying, Request::contacts, &contacts);
    CHECK(answer.signed_distance == Approx(-0.4));
    REQUIRE(contacts.size() == 2);
    for (const Contact& c : contacts) {
      CHECK(c.normal.z() == Approx(1));
      CHECK(c.depth == Approx(0.4));
      CHECK(c.point.z() == Approx(0.8));
      CHECK(std::abs(c.point.y() - 0.1) == Approx(1));
      const VoxelCell& cell = floor.cells()[c.feature / 64];
      CHECK(cell.corner[0] == 3);
      CHECK(cell.corner[1] == 3 + std::floor(c.point.y()));
    }
    contacts.clear();
    n.solve(floor, {}, box, Pose::at(0.95, 0.1, 0.9), Request::contacts, &contacts);
    CHECK(contacts.size() == 4);
    for (const Contact& c : contacts) {
      CHECK(c.normal.z() == Approx(1));
      CHECK(c.depth == Approx(0.2));
    }
    // Across the rows: only some of the cells push it sideways.
    Pose across = lying;
    across.rotation = Eigen::AngleAxisd(0.3, Vec3::UnitZ()) * lying.rotation;
    contacts.clear();
    n.solve(floor, {}, capsule, across, Request::contacts, &contacts);
    REQUIRE(contacts.size() == 2);
    for (const Contact& c : contacts) CHECK(c.depth == Approx(0.4));
    CHECK((contacts[0].point - contacts[1].point).norm() == Approx(2));
  }
}

TEST_CASE("voxels: a contact's feature names a cell that it touches, also where one has hundreds") {
  // A large cell under a hundred small ones, apart from each other, of a set with fewer cells.
  std::vector<std::array<std::int32_t, 3>> small;
  for (std::int32_t i = 0; i < 100; ++i) small.push_back({2 * (i % 10), 2 * (i / 10), 0});
  Voxels v{{{{0, 0, -32}, 5}}, 1};
  for (std::int32_t i = 0; i < 120; ++i) v.cells.push_back({{40 + 2 * i, 0, 0}, 0});
  const Shape ground(v), feet = voxels(small, 1);
  REQUIRE(ground.cells()[0].level == 5);
  for (const bool exchanged : {false, true}) {
    std::vector<Contact> contacts;
    const Pose at = Pose::at(2, 2, -0.01);
    if (exchanged)
      NarrowPhase().solve(feet, at, ground, {}, Request::contacts, &contacts);
    else
      NarrowPhase().solve(ground, {}, feet, at, Request::contacts, &contacts);
    CHECK(contacts.size() == 4);
    for (const Contact& c : contacts) CHECK(c.feature / 64 == 0);
  }
}

TEST_CASE("voxels: the box of a stair and its way to a plane visit few cells, and end where a limit says") {
  std::vector<std::array<std::int32_t, 3>> stair;
  for (std::int32_t i = 0; i < 1 << 17; ++i) stair.push_back({i, i, i});
  const Shape shape = voxels(stair, 0.01);
  int checks = 0;
  WorkLimit limit;
  limit.ended = [&] { return ++checks > 1000000; };
  Pose turned;
  turned.rotation = Eigen::AngleAxisd(0.1, Vec3::UnitX()).toRotationMatrix();
  CHECK(shape.bounds(turned, &limit).hi.x() == Approx(0.01 * (1 << 17)));
  CHECK(checks > 0);
  CHECK(checks < 30);
  checks = 0;
  const NarrowPhase n({.limit = &limit});
  const Shape plane = Plane{{1, 1, 1}, 0};
  const auto t = n.time_of_impact(shape, Pose::at(-5000, 0, 0), Vec3(1, 0, 0), plane, {}, Vec3::Zero(), 1e4);
  REQUIRE(t);
  CHECK(*t == Approx(5000 - 0.03 * (1 << 17)));
  CHECK(checks < 100);
  // All cells of it are equally far.
  limit.ended = [&] { return ++checks > 20; };
  turned.rotation = Eigen::AngleAxisd(std::acos(-1) / 4, Vec3::UnitZ()).toRotationMatrix();
  checks = 0;
  CHECK_THROWS_AS(shape.bounds(turned, &limit), WorkStopped);
}

TEST_CASE("voxels: cells as small and as large as lengths may be, with what has cells itself") {
  const NarrowPhase n;
  for (const double size : {1e-30, 2.4e29}) {
    CAPTURE(size);
    const std::vector<std::array<std::int32_t, 3>> two{{-1, 0, 0}, {0, 0, 0}};
    const Shape pair = voxels(two, size);
    for (const Shape& other : {pair, Shape(Box{size * Vec3(2, 1, 1)}), voxel_mesh(two, size)}) {
      CAPTURE(name(other.kind()));
      const double middle = other.kind() == ShapeKind::box ? size / 2 : 0;
      const auto at = [&](double x) { return Pose::at(x * size, middle, middle); };
      CHECK(n.solve(pair, {}, other, at(1.5), Request::collide).collide);
      CHECK_FALSE(n.solve(pair, {}, other, at(2.5), Request::collide).collide);
      CHECK(n.solve(pair, {}, other, at(2.5), Request::distance).signed_distance == Approx(size / 2).epsilon(1e-8));
      std::vector<Contact> contacts;
      n.solve(pair, {}, other, at(1.75), Request::contacts, &contacts);
      CHECK_FALSE(contacts.empty());
    }
  }
}

TEST_CASE("voxels: with a solver named, verdicts, distances and contacts are those of cells as without") {
  Random r(408);
  const NarrowPhase plain;
  int hits = 0;
  for (const char* solver : {"mpr", "libccd", "gjk"}) {
    const NarrowPhase named({.solver = solver});
    for (int i = 0; i < 20; ++i) {
      const Shape shape = random_voxels(r, 20), other = random_shape(static_cast<ShapeKind>(i % 8), r);
      const Pose at = random_pose(r, 0.5), pose = random_pose(r, 1);
      CAPTURE(solver, i);
      if (!named.refuses(shape, other, Request::collide).empty()) continue;
      const PairAnswer answer = plain.solve(shape, at, other, pose, Request::distance);
      hits += answer.collide;
      CHECK(named.solve(shape, at, other, pose, Request::collide).collide == answer.collide);
      if (!named.refuses(shape, other, Request::distance).empty()) continue;
      CHECK(named.solve(shape, at, other, pose, Request::distance).signed_distance == answer.signed_distance);
      std::vector<Contact> contacts, others;
      plain.solve(shape, at, other, pose, Request::contacts, &contacts);
      named.solve(shape, at, other, pose, Request::contacts, &others);
      REQUIRE(contacts.size() == others.size());
      for (std::size_t c = 0; c < contacts.size(); ++c) CHECK(contacts[c].point == others[c].point);
    }
  }
  CHECK(hits > 5);
}

TEST_CASE("voxels: two sets of cells whose contacts lie on other cells of either touch all the same") {
  const NarrowPhase solver;
  Random r(41);
  const auto cells = [&] {
    std::vector<std::array<std::int32_t, 3>> list;
    for (int n = 2 + r.below(7); n > 0; --n) {
      const int x = r.below(3), y = r.below(3);
      list.push_back({x, y, r.below(2)});
    }
    return list;
  };
  int touching = 0;
  const auto check = [&](const Shape& a, const Shape& b, const Vec3& place) {
    const Pose at{Mat3::Identity(), place};
    std::vector<Contact> contacts;
    const bool collide = solver.solve(a, Pose{}, b, at, Request::collide).collide;
    const PairAnswer distance = solver.solve(a, Pose{}, b, at, Request::distance),
                     whole = solver.solve(a, Pose{}, b, at, Request::contacts, &contacts);
    CHECK(distance.collide == collide);
    CHECK(whole.collide == collide);
    CHECK(contacts.empty() != collide);
    touching += collide ? 1 : 0;
    if (collide)
      CHECK(std::abs(whole.signed_distance - distance.signed_distance) <=
            whole.error_bound + distance.error_bound + 1e-12);
  };
  check(voxels(std::vector<std::array<std::int32_t, 3>>{{0, 0, 0}, {0, 1, 0}}, 1),
        voxels(std::vector<std::array<std::int32_t, 3>>{{1, 2, 0}, {2, 1, 1}}, 1), Vec3(-0.75, -1.5, 0.25));
  for (int i = 0; i < 3000; ++i) {
    CAPTURE(i);
    const Shape a = voxels(cells(), 1), b = voxels(cells(), 1);
    const double x = r.below(17) - 8, y = r.below(17) - 8;
    check(a, b, 0.25 * Vec3(x, y, r.below(9) - 4));
  }
  CHECK(touching > 2000);
}

namespace {

Shape block_of_cells(int x, int y, int z, double edge) {
  std::vector<std::array<std::int32_t, 3>> cells;
  for (int i = 0; i < x; ++i)
    for (int j = 0; j < y; ++j)
      for (int k = 0; k < z; ++k) cells.push_back({i, j, k});
  return voxels(cells, edge);
}

}  // namespace

// Rounding makes cells that touch along an edge as deep as those that touch along a face.
TEST_CASE("voxels: blocks with a face on a face have its normal") {
  Mat3 turn;
  turn.col(0) = Vec3(-0.53895674728087239, -0.67310299849997657, 0.50641680261496269);
  turn.col(1) = Vec3(-0.44391597435175195, -0.28397240568703563, -0.84988133320108394);
  turn.col(2) = Vec3(0.71586607146571501, -0.68285578727770746, -0.14575232933159432);
  const Pose pose{turn, Vec3::Constant(1.0241314713406764)};
  const Pose at{turn, turn * Vec3(0.2, 0.1, 0.2) + pose.translation};
  const Shape a = block_of_cells(3, 5, 2, 0.1), b = block_of_cells(5, 2, 4, 0.1);
  std::vector<Contact> contacts;
  const PairAnswer answer = NarrowPhase().solve(a, pose, b, at, Request::contacts, &contacts);
  CHECK(answer.status == Status::ok);
  REQUIRE(contacts.size() == 4);
  for (const Contact& c : contacts) CHECK(c.normal.dot(turn.col(2)) == Approx(1));
  CHECK(NarrowPhase().solve(a, pose, b, at, Request::distance).normal.dot(turn.col(2)) == Approx(1));
}

// No cell's own direction leaves the others.
TEST_CASE("voxels: a convex shape in the corner of three faces leaves them all, by what it is deep in them") {
  Random r(16);
  const Shape corner = voxels(corner_cells, 1);
  int touching = 0;
  for (int i = 0; i < 600; ++i) {
    const auto [shape, half] = resting_shape(i, r);
    const double deep = i % 2 == 0 ? 0 : std::pow(10, r.in(-12, -3));
    const Pose at_corner{r.rotation(), r.vec(-2, 2)};
    const Pose at{at_corner.rotation, at_corner * (Vec3::Constant(1 - deep) + half)};
    std::vector<Contact> contacts;
    const PairAnswer distance = NarrowPhase().solve(corner, at_corner, shape, at, Request::distance);
    NarrowPhase().solve(corner, at_corner, shape, at, Request::contacts, &contacts);
    touching += distance.collide ? 1 : 0;
    CAPTURE(i, deep, distance.signed_distance, distance.error_bound);
    const double most = std::sqrt(3.0) * deep + 3e-12;
    CHECK(-distance.signed_distance <= most);
    CHECK(-distance.signed_distance + distance.error_bound >= deep - 1e-12);
    if (deep == 0) CHECK(distance.status == Status::ok);
    for (const Contact& c : contacts) CHECK(c.depth <= most);
  }
  CHECK(touching > 500);
}
