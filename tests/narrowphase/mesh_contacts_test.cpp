// Patches of two meshes that overlap slightly: as deep as the least translation, along it, and stable under tiny
// motions.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "ask.h"
#include "catch.h"
#include "mesh_samples.h"
#include "random.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using namespace tandem::test;
using tandem::reference::Random;

namespace {

using Corner = std::array<double, 2>;
using Sides = std::array<std::uint32_t, 3>;

/// A profile, as its corners and triangles that fill it, extruded along z.
Mesh drawn_out(const std::vector<Corner>& profile, const std::vector<Sides>& fill, double half) {
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(profile.size());
  for (const double z : {-half, half})
    for (const auto& [x, y] : profile) mesh.vertices.emplace_back(x, y, z);
  for (const auto& [i, j, k] : fill)
    mesh.triangles.push_back({i + n, j + n, k + n}), mesh.triangles.push_back({i, k, j});
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, j + n}), mesh.triangles.push_back({i, j + n, i + n});
  }
  mesh.solid = true;
  return mesh;
}

Mesh box_body() { return drawn_out({{-.5, -.5}, {.5, -.5}, {.5, .5}, {-.5, .5}}, {{0, 1, 2}, {0, 2, 3}}, .4); }
Mesh l_body() {
  return drawn_out({{-.6, -.6}, {.6, -.6}, {.6, -.2}, {-.2, -.2}, {-.2, .6}, {-.6, .6}},
                   {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}, .3);
}
Mesh t_body() {
  return drawn_out({{-.6, -.2}, {-.2, -.2}, {-.2, -.6}, {.2, -.6}, {.2, -.2}, {.6, -.2}, {.6, .2}, {-.6, .2}},
                   {{0, 1, 7}, {1, 4, 7}, {4, 6, 7}, {4, 5, 6}, {1, 2, 3}, {1, 3, 4}}, .3);
}

/// Each triangle with its own corners, as files have them.
Mesh split(const Mesh& mesh) {
  Mesh out;
  out.solid = mesh.solid;
  for (const auto& t : mesh.triangles) {
    const auto n = static_cast<std::uint32_t>(out.vertices.size());
    for (const std::uint32_t v : t) out.vertices.push_back(mesh.vertices[v]);
    out.triangles.push_back({n, n + 1, n + 2});
  }
  return out;
}

Shape some_body(reference::Random& random, double scale) {
  Mesh mesh;
  switch (random.below(6)) {
    case 0:
      mesh = box_body();
      break;
    case 1:
      mesh = l_body();
      break;
    case 2:
      mesh = t_body();
      break;
    case 3:
      mesh = torus(.5, .2, 12, 7);
      break;
    case 4:
      mesh = torus(.5, .1, 5, 4);
      break;
    default:
      mesh = l_body();
      mesh.solid = false;
  }
  for (Vec3& v : mesh.vertices) v *= scale;
  return Shape(random.once_in(2) ? split(mesh) : mesh);
}

/// As in steps: replacements of contacts that are too deep are found by a search, possibly elsewhere.
std::vector<Contact> contacts_without_bounds(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  std::vector<Contact> contacts;
  NarrowPhase({.mesh_bounds = false}).solve(a, pose_a, b, pose_b, Request::contacts, &contacts);
  return contacts;
}

/// Moves B, which does not touch A there, from pose_b + far * along towards A until it has sunk in by `sink`; false if
/// it misses.
bool sink_in(const Shape& a, const Pose& pose_a, const Shape& b, Pose& pose_b, const Vec3& along, double far,
             double sink) {
  const Vec3 from = pose_b.translation;
  const auto touches = [&](double s) {
    pose_b.translation = from + s * along;
    return collide(a, pose_a, b, pose_b);
  };
  double low = far;
  while (low > -far && !touches(low)) low -= 0.01 * far;
  if (!(low > -far)) return false;
  double high = low + 0.01 * far;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (touches(middle) ? low : high) = middle;
  }
  pose_b.translation = from + (high - sink) * along;
  return true;
}

/// True if each contact of either list has a similar one in the other.
bool alike(const std::vector<Contact>& some, const std::vector<Contact>& others) {
  const auto all_known = [](const std::vector<Contact>& of, const std::vector<Contact>& among) {
    return std::all_of(of.begin(), of.end(), [&](const Contact& c) {
      return std::any_of(among.begin(), among.end(), [&](const Contact& o) {
        return (o.point - c.point).norm() < 1e-6 && (o.normal - c.normal).norm() < 1e-4 &&
               std::abs(o.depth - c.depth) < 1e-6;
      });
    });
  };
  return all_known(some, others) && all_known(others, some);
}

}  // namespace

TEST_CASE("a mesh body with an edge or a corner in a mesh wall is pushed along the wall's normal, as deep as it is") {
  reference::Random random(51);
  const Shape wall(
      Mesh{{Vec3(-4, -4, 0), Vec3(4, -4, 0), Vec3(4, 4, 0), Vec3(-4, 4, 0)}, {{0, 1, 2}, {0, 2, 3}}, false});
  for (int i = 0; i < 400; ++i) {
    Mesh mesh = i % 2 == 0 ? l_body() : t_body();
    mesh.solid = i % 4 < 2;
    const Shape body(mesh);
    const Pose pose_a{random.rotation(), random.vec(-1, 1)};
    // Edges of the profile parallel to the wall, corners where it leans.
    Mat3 turn =
        (Eigen::AngleAxisd(random.in(0, 6), Vec3::UnitZ()) * Eigen::AngleAxisd(random.in(0.1, 1.4), Vec3::UnitX()))
            .toRotationMatrix();
    if (i % 3 == 0) turn = turn * random.rotation();
    const Pose pose_b{pose_a.rotation * turn, Vec3::Zero()};
    double lowest = 1e9;
    for (const Vec3& v : mesh.vertices) lowest = std::min(lowest, (turn * v).z());
    const double depth = random.power_of_two(-24, -9);
    const Pose at{pose_b.rotation,
                  pose_a.rotation * Vec3{random.in(-1, 1), random.in(-1, 1), -lowest - depth} + pose_a.translation};
    const std::vector<Contact> contacts = contacts_without_bounds(wall, pose_a, body, at);
    CAPTURE(i, depth);
    REQUIRE(!contacts.empty());
    double deepest = 0;
    for (const Contact& c : contacts) {
      CHECK((c.normal - pose_a.rotation.col(2)).norm() < 1e-6);
      deepest = std::max(deepest, c.depth);
    }
    CHECK(std::abs(deepest - depth) < 1e-12);
  }
}

TEST_CASE(
    "where two concave meshes overlap a little, the patch is as deep as the least translation, and stays the same") {
  reference::Random random(52);
  int judged = 0, nudged = 0, farther = 0;
  for (int i = 0; i < 2500; ++i) {
    const Shape a = some_body(random, 1), b = some_body(random, random.power_of_two(-2, 0));
    Mat3 turn = random.rotation();
    if (i % 3 == 1) turn = Eigen::AngleAxisd(random.in(0, 6), Vec3::UnitZ()).toRotationMatrix();
    if (i % 3 == 2) turn = Eigen::AngleAxisd(random.in(0, 6), Vec3::UnitX()).toRotationMatrix();
    const Pose pose_a{random.rotation(), random.vec(-1, 1)};
    const Vec3 along = random.once_in(2) ? Vec3(pose_a.rotation.col(2)) : random.direction();
    Pose pose_b{pose_a.rotation * turn, pose_a.translation + 0.3 * random.vec(-1, 1)};
    if (!sink_in(a, pose_a, b, pose_b, along, 3, random.power_of_two(-20, -8))) continue;
    const PairAnswer answer = NarrowPhase().solve(a, pose_a, b, pose_b, Request::distance);
    const std::vector<Contact> contacts = contacts_without_bounds(a, pose_a, b, pose_b);
    CAPTURE(i);
    REQUIRE(!contacts.empty());
    const auto deepest = std::max_element(contacts.begin(), contacts.end(),
                                          [](const Contact& x, const Contact& y) { return x.depth < y.depth; });
    const bool one_normal = std::all_of(contacts.begin(), contacts.end(),
                                        [&](const Contact& c) { return c.normal.dot(deepest->normal) > 0.9999; });
    if (one_normal && answer.status == Status::ok && -answer.signed_distance > 1e-10) {
      CHECK(deepest->depth > -0.7 * answer.signed_distance);
      // For edges that cross obliquely the curve's normal may give a longer translation.
      farther += deepest->depth > -1.3 * answer.signed_distance;
      ++judged;
    }
    Pose nudge = pose_b;
    nudge.translation += 1e-9 * random.direction();
    if (i % 2 == 0) nudge.rotation = nudge.rotation * Eigen::AngleAxisd(1e-9, random.direction()).toRotationMatrix();
    CHECK(alike(contacts, contacts_without_bounds(a, pose_a, b, nudge)));
    ++nudged;
  }
  CHECK(farther <= 2);
  CHECK(judged > 2000);
  CHECK(nudged > 2200);
}

TEST_CASE("a mesh body across the ridge of a roof without an inside has the same contacts a hair away") {
  reference::Random random(53);
  int judged = 0;
  for (int i = 0; i < 1500; ++i) {
    const double left = random.in(0.1, 1.2), right = random.in(0.1, 1.2);
    const Vec3 l(-4 * std::cos(left), 0, -4 * std::sin(left)), r(4 * std::cos(right), 0, -4 * std::sin(right));
    const Vec3 front(0, -4, 0), back(0, 4, 0);
    Mesh surface{
        {l + front, front, r + front, l + back, back, r + back}, {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}}, false};
    if (i % 4 < 2)
      for (auto& t : surface.triangles) std::swap(t[0], t[1]);
    const Shape roof(i % 3 == 0 ? split(surface) : surface);
    Mesh mesh = i % 2 == 0 ? l_body() : t_body();
    for (Vec3& v : mesh.vertices) v *= 0.3;
    const Shape body(mesh);
    const Pose pose_a{random.rotation(), random.vec(-1, 1)};
    const Vec3 beside{random.in(-.3, .3), random.in(-1, 1), 0};
    Pose pose_b{random.rotation(), pose_a.translation + pose_a.rotation * beside};
    const Vec3 from = (i % 3 == 0 ? -1.0 : 1.0) * pose_a.rotation.col(2);
    if (!sink_in(roof, pose_a, body, pose_b, from, 3, random.power_of_two(-20, -8))) continue;
    const std::vector<Contact> contacts = contacts_without_bounds(roof, pose_a, body, pose_b);
    const PairAnswer answer = NarrowPhase().solve(roof, pose_a, body, pose_b, Request::distance);
    double deepest = 0;
    for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
    CAPTURE(i);
    if (answer.status == Status::ok) CHECK(deepest > -0.7 * answer.signed_distance);
    Pose nudge = pose_b;
    nudge.translation += 1e-9 * random.direction();
    CHECK(alike(contacts, contacts_without_bounds(roof, pose_a, body, nudge)));
    ++judged;
  }
  CHECK(judged > 1300);
}

TEST_CASE("where a convex body overlaps a concave mesh a little, contacts are as deep as the least translation") {
  reference::Random random(54);
  int judged = 0;
  for (int i = 0; i < 3000; ++i) {
    const Shape a = some_body(random, 1);
    const double scale = random.power_of_two(-3, -1);
    const auto body = [&]() -> Shape {
      switch (i % 6) {
        case 0:
          return Sphere{0.5 * scale};
        case 1:
          return Box{scale * Vec3(1, 0.8, 0.6)};
        case 2:
          return Capsule{0.3 * scale, scale};
        case 3:
          return Cylinder{0.5 * scale, scale};
        case 4:
          return Cone{0.5 * scale, scale};
        default:
          return Ellipsoid{scale * Vec3(0.6, 0.4, 0.3)};
      }
    };
    const Shape b = body();
    const Pose pose_a{random.rotation(), random.vec(-1, 1)};
    const Vec3 along = random.once_in(2) ? Vec3(pose_a.rotation.col(2)) : random.direction();
    Pose pose_b{random.rotation(), pose_a.translation + 0.4 * random.vec(-1, 1)};
    if (!sink_in(a, pose_a, b, pose_b, along, 3, random.power_of_two(-20, -9))) continue;
    const PairAnswer answer = NarrowPhase().solve(a, pose_a, b, pose_b, Request::distance);
    const std::vector<Contact> contacts = contacts_without_bounds(a, pose_a, b, pose_b);
    CAPTURE(i);
    REQUIRE(!contacts.empty());
    double deepest = 0;
    bool one_normal = true;
    for (const Contact& c : contacts) {
      deepest = std::max(deepest, c.depth);
      one_normal = one_normal && c.normal.dot(contacts.front().normal) > 0.9999;
    }
    if (!one_normal || answer.status != Status::ok) continue;
    CHECK(std::abs(deepest + answer.signed_distance) < -0.01 * answer.signed_distance + 1e-10);
    ++judged;
  }
  CHECK(judged > 2500);
}

TEST_CASE("at the end of an edge what rises on beyond it pushes, not the edge") {
  // The reentrant corner of the profile, on its upper face: one edge ends there, the face continues beside it.
  const Shape body(l_body());
  const Vec3 corner(-.2, -.2, .3);
  for (const double lean : {0.05, 0.1, 0.2, 0.3}) {
    const Vec3 away = Vec3(0, lean, 1).normalized();
    const std::vector<Contact> contacts =
        contacts_without_bounds(body, Pose{}, Sphere{0.1}, Pose{Mat3::Identity(), corner + 0.0999 * away});
    CAPTURE(lean);
    REQUIRE(!contacts.empty());
    for (const Contact& c : contacts) CHECK((c.normal - Vec3::UnitZ()).norm() < 1e-9);
  }
}

TEST_CASE("rounded meshes: only contacts whose own translation does not separate are lost") {
  const Shape body(drawn_out({{-.8, -.8}, {1.2, -.8}, {1.2, .2}, {.2, .2}, {.2, 1.2}, {-.8, 1.2}},
                             {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, .5));
  const Shape a = body.rounded(.05), b = body.rounded(.03);
  const NarrowPhase narrow;
  for (const Vec3& at : {Vec3(-.75, -.5, .75), Vec3(.75, .75, .75)}) {
    const Pose pose_b{Mat3::Identity(), at};
    std::vector<Contact> contacts;
    const PairAnswer answer = narrow.solve(a, Pose{}, b, pose_b, Request::contacts, &contacts);
    CAPTURE(at.transpose());
    CHECK(answer.status == Status::ok);
    CHECK(contacts.size() == 4);  // along z: as many along others do not separate
    double deepest = 0;
    for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
    CHECK(deepest == -answer.signed_distance);
    for (const Contact& c : contacts) {
      if (c.depth < deepest - 1e-9) continue;
      const Pose out{Mat3::Identity(), at + (c.depth + 1e-9) * c.normal};
      CHECK(narrow.solve(a, Pose{}, b, out, Request::distance).signed_distance > -2e-9);
    }
  }
}

TEST_CASE("the contact of a ring in a ring lies in both, and tiny motions hardly move it") {
  const auto ring = [](double inner, double outer, double half) {
    constexpr std::uint32_t sides = 16;
    Mesh mesh;
    for (std::uint32_t i = 0; i < sides; ++i) {
      const double angle = i * (2 * 3.14159265358979323846 / sides), c = std::cos(angle), s = std::sin(angle);
      for (const auto& [r, z] : {std::pair{inner, -half}, {outer, -half}, {outer, half}, {inner, half}})
        mesh.vertices.emplace_back(r * c, r * s, z);
      const std::uint32_t here = 4 * i, next = 4 * ((i + 1) % sides);
      for (std::uint32_t k = 0; k < 4; ++k) {
        const std::uint32_t l = (k + 1) % 4;
        mesh.triangles.push_back({here + k, next + l, here + l});
        mesh.triangles.push_back({here + k, next + k, next + l});
      }
    }
    mesh.solid = true;
    return Shape(mesh);
  };
  const Shape inner = ring(.75, .85, .05), outer = ring(.6, 1, .3);
  REQUIRE(inner.mass().volume > 0);
  const auto contact = [](const Shape& a, const Shape& b, const Vec3& at) {
    std::vector<Contact> contacts;
    NarrowPhase().solve(a, Pose{}, b, Pose{Mat3::Identity(), at}, Request::contacts, &contacts);
    REQUIRE(contacts.size() == 1);
    return contacts[0];
  };
  const Contact first = contact(inner, outer, Vec3::Zero());
  CHECK(std::abs(first.normal.z()) > 0.9999);
  CHECK(std::abs(first.point.z()) < 1e-9);
  CHECK(first.point.norm() > .75 * std::cos(3.15 / 16) - 1e-9);
  CHECK(first.point.norm() < .85 + 1e-9);
  CHECK((contact(outer, inner, Vec3::Zero()).point - first.point).norm() < 1e-9);
  for (const Vec3& moved : {Vec3(1e-9, 0, 0), Vec3(0, -1e-9, 0), Vec3(-1e-9, 1e-9, 1e-9)})
    CHECK((contact(inner, outer, moved).point - first.point).norm() < 1e-8);
}

// The points where two triangles pierce each other have no depth, whatever the normal.
TEST_CASE("mesh contacts: where surfaces without an inside cross, no contact lacks a depth") {
  reference::Random random(5);
  const auto triangles = [&](int count) {
    Mesh mesh;
    for (int i = 0; i < count; ++i) {
      const auto n = static_cast<std::uint32_t>(mesh.vertices.size());
      const Vec3 middle = count > 1 ? random.vec(-0.7, 0.7) : Vec3(Vec3::Zero());
      for (int k = 0; k < 3; ++k) mesh.vertices.push_back(middle + random.vec(-0.8, 0.8));
      mesh.triangles.push_back({n, n + 1, n + 2});
    }
    return Shape(mesh);
  };
  const Shape tube(torus(1, 0.3, 10, 6));
  for (const bool bounds : {true, false}) {
    const NarrowPhase narrow({.mesh_bounds = bounds});
    int crossing = 0, without = 0;
    for (int i = 0; i < 900; ++i) {
      const Shape a = i % 3 == 2 ? tube : triangles(i % 3 == 1 ? 4 : 1), b = triangles(i % 3 == 1 ? 4 : 1);
      const Mat3 turn = random.rotation();
      const Pose at{turn, random.vec_of_length(0, 1)};
      std::vector<Contact> contacts;
      const PairAnswer answer = narrow.solve(a, Pose{}, b, at, Request::contacts, &contacts);
      if (!answer.collide || narrow.solve(a, Pose{}, b, at, Request::distance).signed_distance > -1e-6) continue;
      ++crossing;
      if (std::any_of(contacts.begin(), contacts.end(), [](const Contact& c) { return c.depth < 1e-12; })) ++without;
    }
    CHECK(crossing > 300);
    CHECK(without == 0);
  }
}

TEST_CASE("mesh contacts: strips that pierce each other are as deep in whatever order their triangles come") {
  reference::Random random(6);
  const auto strip = [&](std::uint32_t squares, bool backwards) {
    reference::Random bend(7);
    Mesh mesh;
    for (std::uint32_t i = 0; i <= squares; ++i)
      for (const double y : {-0.5, 0.5}) mesh.vertices.emplace_back(2.0 * i / squares - 1, y, bend.in(-0.1, 0.1));
    for (std::uint32_t i = 0; i < squares; ++i) {
      mesh.triangles.push_back({2 * i, 2 * i + 2, 2 * i + 1});
      mesh.triangles.push_back({2 * i + 1, 2 * i + 2, 2 * i + 3});
    }
    if (backwards) std::reverse(mesh.triangles.begin(), mesh.triangles.end());
    return Shape(mesh);
  };
  const Shape a = strip(60, false), reversed_a = strip(60, true), b = strip(2, false), reversed_b = strip(2, true);
  const NarrowPhase narrow({.mesh_bounds = false});
  int crossing = 0, deep = 0, other = 0;
  for (int i = 0; i < 500; ++i) {
    const double lean = random.in(0.3, 1.3), aside = random.in(-0.3, 0.3), along = random.in(-0.3, 0.3);
    const double c = std::cos(lean), s = std::sin(lean);
    Mat3 turn;
    turn << 1, 0, 0, 0, c, -s, 0, s, c;
    const Pose at{turn, Vec3(along, aside, 0)};
    std::vector<Contact> contacts, reversed;
    const PairAnswer answer = narrow.solve(a, Pose{}, b, at, Request::contacts, &contacts);
    const PairAnswer again = narrow.solve(reversed_a, Pose{}, reversed_b, at, Request::contacts, &reversed);
    if (!answer.collide) continue;
    ++crossing;
    if (-answer.signed_distance > 1e-9) ++deep;
    if (contacts.size() != reversed.size() || std::abs(answer.signed_distance - again.signed_distance) > 1e-12) ++other;
  }
  CAPTURE(crossing, deep, other);
  CHECK(crossing > 400);
  CHECK(deep == crossing);
  CHECK(other == 0);
}

TEST_CASE("mesh contacts: a touch that rounding leaves to some triangles has contacts all around") {
  reference::Random random(31);
  int touching = 0;
  for (int i = 0; i < 300; ++i) {
    const Shape plate{box_mesh({2, 2.2, 0.5}, 2 + i % 4)}, body{box_mesh({1, 0.9, 0.6}, 1 + i % 3)};
    const Mat3 turn = random.rotation();
    const double angle = random.in(0, 7), x = random.in(-0.3, 0.3), y = random.in(-0.3, 0.3);
    const Pose at_plate{turn, random.vec(-3, 3)};
    Mat3 yaw;
    yaw << std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1;
    const Pose at_body{turn * yaw, at_plate * Vec3(x, y, 0.55)};
    std::vector<Contact> contacts;
    NarrowPhase().solve(plate, at_plate, body, at_body, Request::contacts, &contacts);
    if (contacts.empty()) continue;
    ++touching;
    CAPTURE(i);
    const Vec3 centre = at_plate * Vec3(x, y, 0.25);
    for (int k = 0; k < 16; ++k) {
      const double round = k * std::numbers::pi / 8;
      const Vec3 direction = turn * Vec3(std::cos(round), std::sin(round), 0);
      double farthest = 0;
      for (const Contact& c : contacts) farthest = std::max(farthest, direction.dot(c.point - centre));
      CHECK(farthest > 0.2);
    }
  }
  CHECK(touching > 100);
}

TEST_CASE("mesh-mesh: over a gap each contact has the normal of its own face, also where faces differ by one degree") {
  Random r(2);
  std::size_t contacts = 0;
  for (int i = 0; i < 60; ++i) {
    const double sign = r.below(2) == 0 ? 1 : -1, slope = sign * std::tan(r.in(0.2, 1.1) * std::numbers::pi / 180),
                 gap = std::pow(10, r.in(-11, -5));
    const Mesh slab = prism({{-1, -1}, {1, -1}, {1, slope}, {0, 0}, {-1, 0}}, {{0, 1, 3}, {1, 2, 3}, {0, 3, 4}}, 1),
               lid = prism({{-0.9, 0}, {0, 0}, {0.9, 0.9 * slope}, {0.9, 1}, {-0.9, 1}},
                           {{0, 1, 4}, {1, 3, 4}, {1, 2, 3}}, 0.8);
    const Mat3 turn = r.rotation();
    const Vec3 place = r.vec(-1, 1);
    std::vector<Contact> found;
    NarrowPhase({.margin = 1e-4})
        .solve(Shape(slab), {turn, place}, Shape(lid), {turn, place + turn * Vec3(0, gap, 0)}, Request::contacts,
               &found);
    CAPTURE(i, slope, gap);
    for (const Contact& c : found) {
      const Vec3 at = turn.transpose() * (c.point - place), n = turn.transpose() * c.normal;
      if (std::abs(at.x()) < 1e-6) continue;
      CHECK((n - Vec3(at.x() > 0 ? -slope : 0, 1, 0).normalized()).norm() < 1e-5);
      ++contacts;
    }
  }
  CHECK(contacts > 200);
}
