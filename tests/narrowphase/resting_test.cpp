// Bodies at rest against several faces: flush with some, sunk into others, in notches, cups and slots.
#include <algorithm>
#include <numbers>
#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "random_pairs.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/penetration.h"
#include "tandem/narrowphase/shape_makers.h"

using namespace tandem;
using namespace tandem::test;

namespace {

double deepest(const std::vector<Contact>& contacts) {
  double most = -1;
  for (const Contact& c : contacts) most = std::max(most, c.depth);
  return most;
}

std::vector<Contact> contacts_of(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  std::vector<Contact> found;
  NarrowPhase().solve(a, pose_a, b, pose_b, Request::contacts, &found);
  return found;
}

/// A box within a box: its inner faces are walls.
Mesh room(const Vec3& inner, double wall) {
  return with_hollow(box_mesh(inner + Vec3::Constant(2 * wall), 1), box_mesh(inner, 2));
}

using Profile = std::vector<std::array<double, 2>>;
using Caps = std::vector<std::array<std::uint32_t, 3>>;

/// Open above: its floor at y = 0, walls at x = -1 and 1.
Mesh channel() {
  const Profile outline{{-2, -1}, {2, -1}, {2, 1}, {1, 1}, {1, 0}, {-1, 0}, {-1, 1}, {-2, 1}};
  return prism(outline, Caps{{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}}, 2);
}

/// An L, 1 wide and 2 high, standing on y = 0 with a side at x = 1.
Mesh angle() {
  const Profile outline{{0, 0}, {1, 0}, {1, 2}, {0.5, 2}, {0.5, 0.5}, {0, 0.5}};
  return prism(outline, Caps{{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}}, 1);
}

/// A cup of four faces, each rising by 2 within 1 from its apex at the origin.
Mesh cup() {
  const double r = 1, h = 2, out = 3;
  Mesh m;
  m.solid = true;
  for (const auto& [size, z] : {std::pair(r, h), std::pair(out, h), std::pair(out, -1.0)})
    for (int k = 0; k < 4; ++k) m.vertices.emplace_back(k % 3 == 0 ? size : -size, k < 2 ? size : -size, z);
  m.vertices.emplace_back(0, 0, 0);
  for (std::uint32_t k = 0; k < 4; ++k) {
    const std::uint32_t j = (k + 1) % 4;
    m.triangles.push_back({12, k, j});
    for (const auto& t : {std::array{k, 4 + k, 4 + j}, std::array{k, 4 + j, j}, std::array{4 + k, 8 + k, 8 + j},
                          std::array{4 + k, 8 + j, 4 + j}})
      m.triangles.push_back({t[0], t[1], t[2]});
  }
  m.triangles.push_back({8, 11, 10});
  m.triangles.push_back({8, 10, 9});
  return m;
}

}  // namespace

TEST_CASE("resting: a point or a thin body on a wall of a room leaves it inwards") {
  Random r(3201);
  const NarrowPhase solver;
  for (int i = 0; i < 400; ++i) {
    const Vec3 inner = r.vec(0.5, 2);
    const Shape walls(room(inner, 0.125));
    const Pose at{r.rotation(), Vec3::Zero()};
    // Within the wall at x, on it or into it by up to 1e-7; a segment may also be flush with that at y.
    const double sunk = i % 3 == 0 ? 0 : std::pow(10.0, -r.in(7, 13));
    Vec3 place(inner.x() / 2 + sunk, r.in(-0.4, 0.4) * inner.y(), r.in(-0.4, 0.4) * inner.z());
    Shape body(Sphere{0});
    if (i % 4 == 1) body = Shape(Convex{{Vec3::Zero(), Vec3(0, 1e-3 * r.unit(), 1e-3)}});
    if (i % 4 == 2) body = Shape(Triangle{{Vec3::Zero(), Vec3(0, 0, 1e-3), Vec3(0, 1e-3, 0)}});
    if (i % 4 == 3) {
      body = Shape(Convex{{Vec3::Zero(), Vec3(0, 0, 1e-3)}});
      place.y() = inner.y() / 2;
    }
    CAPTURE(i, sunk);
    const Pose pose{at.rotation, at.rotation * place};

    const PairAnswer answer = solver.solve(walls, at, body, pose, Request::distance);
    CHECK(answer.signed_distance == Approx(-sunk).epsilon(0).margin(1e-9));
    CHECK(answer.error_bound <= 1e-9 + sunk);
    CHECK(deepest(contacts_of(walls, at, body, pose)) <= sunk + 1e-9);
  }
}

TEST_CASE("resting: a body that is not convex, flush with a wall and sunk into the floor, leaves upwards") {
  const NarrowPhase solver;
  const Shape a(channel()), b(angle());
  Random r(3202);
  for (int i = 0; i < 60; ++i) {
    const double sunk = i % 2 == 0 ? 1 / 64.0 : std::pow(10.0, -r.in(2, 9));
    Pose at;
    if (i % 3 == 2) at.rotation = r.rotation();
    const Pose pose{at.rotation, at.rotation * Vec3(0, -sunk, 0)};
    CAPTURE(i, sunk);
    const PairAnswer answer = solver.solve(a, at, b, pose, Request::distance);
    CHECK(answer.signed_distance == Approx(-sunk).epsilon(1e-9).margin(1e-11));
    CHECK(answer.error_bound <= 1e-11);
    CHECK(answer.normal.dot(at.rotation.col(1)) > 1 - 1e-4);
    const std::vector<Contact> found = contacts_of(a, at, b, pose);
    CHECK(deepest(found) >= sunk * (1 - 1e-9) - 1e-11);
    CHECK(deepest(found) <= 1.1 * sunk + 1e-11);
  }
}

TEST_CASE("resting: contacts of a rail in a slot that it hardly sinks into are not as deep as it is long") {
  const Profile slot{{-2, -1},    {2, -1},      {2, 0.875},        {0.375, 0.875},   {0.375, 0.4375}, {0.8125, 0.4375},
                     {0.8125, 0}, {-0.8125, 0}, {-0.8125, 0.4375}, {-0.375, 0.4375}, {-0.375, 0.875}, {-2, 0.875}};
  const Mesh a = prism(slot,
                       Caps{{2, 3, 4},
                            {2, 4, 5},
                            {1, 2, 5},
                            {1, 5, 6},
                            {0, 1, 6},
                            {0, 6, 7},
                            {11, 0, 7},
                            {11, 7, 8},
                            {11, 8, 9},
                            {9, 10, 11}},
                       2);
  const Profile rail{{-0.6875, 0},   {0.6875, 0},     {0.6875, 0.3375}, {0.25, 0.3375},
                     {0.25, 1.3125}, {-0.25, 1.3125}, {-0.25, 0.3375},  {-0.6875, 0.3375}};
  const Mesh b =
      prism(rail, Caps{{7, 0, 1}, {1, 2, 3}, {3, 4, 5}, {3, 5, 6}, {1, 3, 6}, {1, 6, 7}}, 2 * 0.9365387327976717);
  const double sunk = 0x1p-17;
  for (const double along : {0.13741590442426532, 0.05, 0.5}) {
    const Pose pose = Pose::at(0.125, -sunk, along);
    const std::vector<Contact> found = contacts_of(Shape(a), {}, Shape(b), pose);
    REQUIRE_FALSE(found.empty());
    CHECK(deepest(found) <= sunk + 1e-11);
    CHECK(NarrowPhase().solve(Shape(a), {}, Shape(b), pose, Request::distance).signed_distance ==
          Approx(-sunk).epsilon(0).margin(1e-11));
  }
}

// Shifted by (2, 0, -1)/64, it overlaps one face by sqrt(5)/64 and ends, moved by that, along two others.
TEST_CASE("resting: a pyramid in its cup leaves to the other side of the notch") {
  const std::vector<Vec3> pyramid{{.5, .5, 1}, {-.5, .5, 1}, {-.5, -.5, 1}, {.5, -.5, 1}, {0, 0, 0}};
  const Shape a(cup()), b(Convex{pyramid});
  const Pose pose = Pose::at(2 / 64.0, 0, -1 / 64.0);
  const double depth = std::sqrt(5.0) / 64;
  const PairAnswer answer = NarrowPhase().solve(a, {}, b, pose, Request::distance);
  CHECK(answer.signed_distance == Approx(-depth).epsilon(1e-12));
  CHECK(answer.status == Status::ok);
  const DepthBounds bounds = penetration_depth(a, {}, b, pose);
  CHECK(bounds.lower <= depth + 1e-12);
  CHECK(bounds.upper == Approx(depth).epsilon(1e-9));
}

TEST_CASE("resting: contacts in a slot exactly as wide as the body are not deep") {
  std::vector<std::array<std::int32_t, 3>> cells;
  for (int x = -2; x < 2; ++x)
    for (int y = -2; y < 2; ++y)
      for (int z = -1; z < 1; ++z)
        if (z < 0 || x < -1 || x > 0 || y < -1 || y > 0) cells.push_back({x, y, z});
  Voxels pocket;
  pocket.cell_size = 1;
  for (const auto& c : cells) pocket.cells.push_back({c, 0});
  const Shape voxels(pocket);
  for (const Shape& body : {Shape(Box{Vec3(2, 2, 1)}), Shape(Cylinder{1, 1}), Shape(box_mesh(Vec3(2, 2, 1), 2))}) {
    const std::vector<Contact> found = contacts_of(voxels, {}, body, Pose::at(0, 0, 0.5));
    REQUIRE_FALSE(found.empty());
    CHECK(deepest(found) <= 1e-12);
  }
  const Profile tee{{-1, 0}, {1, 0}, {1, 0.5}, {0.25, 0.5}, {0.25, 2}, {-0.25, 2}, {-0.25, 0.5}, {-1, 0.5}};
  const Mesh body = prism(tee, Caps{{7, 0, 1}, {1, 2, 3}, {3, 4, 5}, {3, 5, 6}, {1, 3, 6}, {1, 6, 7}}, 1);
  const std::vector<Contact> found = contacts_of(Shape(channel()), {}, Shape(body), {});
  REQUIRE_FALSE(found.empty());
  CHECK(deepest(found) <= 1e-12);
}
