// Bounds on the depth, compared with closed forms and with their meaning: after the translation the two are separated,
// after any translation shorter than the lower bound they collide.
#include "tandem/narrowphase/penetration.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "catch.h"
#include "mesh_samples.h"
#include "random.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/work_limit.h"

using namespace tandem;
using namespace tandem::test;

namespace {

using reference::Random;

constexpr double turn = 2 * std::numbers::pi;

/// A closed profile of radii and heights, counterclockwise, revolved about z.
Mesh turned(const std::vector<std::array<double, 2>>& profile, std::uint32_t around) {
  Mesh mesh;
  mesh.solid = true;
  const auto n = static_cast<std::uint32_t>(profile.size());
  for (std::uint32_t i = 0; i < around; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const double angle = turn * i / around, radius = profile[j][0];
      mesh.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), profile[j][1]);
      const std::uint32_t k = (i + 1) % around, l = (j + 1) % n;
      mesh.triangles.push_back({n * i + j, n * k + j, n * k + l});
      mesh.triangles.push_back({n * i + j, n * k + l, n * i + l});
    }
  return mesh;
}

Mesh ring(double inner, double outer, double height, std::uint32_t around = 24) {
  const double h = height / 2;
  return turned({{outer, -h}, {outer, h}, {inner, h}, {inner, -h}}, around);
}

/// A bowl open upwards with a hole in its bottom, between two spheres.
Mesh bowl(double inner, double outer, int rows, std::uint32_t around) {
  std::vector<std::array<double, 2>> profile;
  const double lowest = 0.1, highest = turn / 4;
  for (int k = 0; k <= rows; ++k) {
    const double angle = lowest + (highest - lowest) * k / rows;
    profile.push_back({outer * std::sin(angle), -outer * std::cos(angle)});
  }
  for (int k = rows; k >= 0; --k) {
    const double angle = lowest + (highest - lowest) * k / rows;
    profile.push_back({inner * std::sin(angle), -inner * std::cos(angle)});
  }
  return turned(profile, around);
}

Mesh bumpy_ball(double radius, double bump, double phase) {
  constexpr int around = 24, rows = 12;
  Mesh mesh;
  mesh.solid = true;
  const auto point = [&](int i, int j) -> Vec3 {
    const double u = turn * i / around, v = turn / 2 * j / rows;
    const Vec3 d(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v));
    return radius * (1 + bump * std::sin(4 * d.x() + phase) * std::cos(3 * d.y() - phase) * std::cos(2 * d.z())) * d;
  };
  mesh.vertices = {point(0, 0), point(0, rows)};
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(2 + (j - 1) * around + i % around); };
  for (int j = 1; j < rows; ++j)
    for (int i = 0; i < around; ++i) mesh.vertices.push_back(point(i, j));
  for (int i = 0; i < around; ++i) {
    mesh.triangles.push_back({0, at(i, 1), at(i + 1, 1)});
    mesh.triangles.push_back({1, at(i + 1, rows - 1), at(i, rows - 1)});
    for (int j = 1; j + 1 < rows; ++j) {
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  }
  return mesh;
}

bool collide(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& move) {
  return NarrowPhase().solve(a, pose_a, b, {pose_b.rotation, pose_b.translation + move}, Request::collide).collide;
}

/// Checks the documented properties of any bounds; returns how often a translation shorter than the lower one was
/// tried.
void check_promise(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const DepthBounds& bounds,
                   Random& random, int moves = 300) {
  CAPTURE(bounds.lower, bounds.upper, bounds.translation.transpose());
  REQUIRE(bounds.collide);
  CHECK((0 <= bounds.lower && bounds.lower <= bounds.upper));
  CHECK(bounds.upper == bounds.translation.norm());
  CHECK_FALSE(collide(a, pose_a, b, pose_b, bounds.translation));
  for (int i = 0; i < moves; ++i) {
    // Nearly as long as the lower bound, half of them near the translation, where least is in the way.
    const Vec3 about = bounds.translation.normalized() + random.vec_of_length(0, 0.3);
    const Vec3 move = 0.9999 * bounds.lower * (i % 2 == 0 ? random.direction() : about.normalized());
    CAPTURE(move.transpose());
    REQUIRE(collide(a, pose_a, b, pose_b, move));
  }
}

/// Places both in a random pose, with B relative to A as given.
void check_depth(const Mesh& of_a, const Mesh& of_b, const Vec3& between, double least, double most) {
  Random random(71);
  const Shape a(of_a), b(of_b);
  for (const double far : {0.0, 1000.0}) {
    const Mat3 turned = far == 0 ? Mat3::Identity() : random.rotation();
    const Pose pose_a{turned, far * random.direction()}, pose_b{turned, turned * between + pose_a.translation};
    const DepthBounds bounds = penetration_depth(a, pose_a, b, pose_b);
    check_promise(a, pose_a, b, pose_b, bounds, random);
    CAPTURE(least, most, bounds.boxes);
    CHECK(bounds.lower <= most);
    CHECK(bounds.upper >= least * (1 - 1e-9));
    CHECK(bounds.lower >= 0.95 * bounds.upper * (1 - 1e-9));
  }
}

}  // namespace

TEST_CASE("penetration: of boxes, as meshes and as boxes, it is the least overlap along an axis") {
  Random random(5);
  for (int i = 0; i < 40; ++i) {
    const Vec3 size_a = random.vec(0.5, 2), size_b = random.vec(0.5, 2), at = 0.2 * random.vec(-1, 1);
    const double depth = ((size_a + size_b) / 2 - at.cwiseAbs()).minCoeff();
    const Pose pose_b{Mat3::Identity(), at};
    const Shape mesh_a(box_mesh(size_a, 2)), mesh_b(box_mesh(size_b)), box_b(Box{size_b});
    for (const Shape* b : {&mesh_b, &box_b}) {
      const DepthBounds bounds = penetration_depth(mesh_a, {}, *b, pose_b);
      CHECK(std::abs(bounds.upper - depth) < 1e-9);
      CHECK(std::abs(bounds.lower - depth) < 1e-9);
      CHECK_FALSE(collide(mesh_a, {}, *b, pose_b, bounds.translation));
    }
  }
}

TEST_CASE("penetration: solids in each other whose depth is known") {
  // A torus in itself, or in a thicker one of the same radius: the shortest is along the axis; otherwise its ring
  // crosses itself.
  const double flat = std::cos(turn / 2 / 16) * std::cos(turn / 2 / 32);
  check_depth(torus(1, 0.25, 32, 16), torus(1, 0.25, 32, 16), Vec3::Zero(), flat * 0.5, 0.5);
  check_depth(torus(1, 0.25, 32, 16), torus(1, 0.15, 32, 16), Vec3::Zero(), flat * 0.4, 0.4);
  // A ring on a peg thicker than its hole: off over the nearer end.
  check_depth(ring(0.5, 0.8, 0.4), ring(0.05, 0.55, 2), {0, 0, 0.1}, 1.1, 1.1);
  // A ball in a bowl of a smaller radius: up until it rests on the edge.
  const double up = std::sqrt(0.85 * 0.85 - 0.8 * 0.8);
  check_depth(bowl(0.8, 1, 8, 32), bumpy_ball(0.85, 0, 0), Vec3::Zero(), 0.9 * up, 1.1 * up);
  // A ball in a ball, both with hills and hollows of a tenth: neither is convex.
  check_depth(bumpy_ball(1, 0.1, 0.5), bumpy_ball(0.7, 0.1, 2), Vec3::Zero(), 0.9 * 1.7 * 0.95, 1.1 * 1.7);
}

TEST_CASE("penetration: bowls, rings, tori and balls with hills, turned anyhow, deep in each other") {
  Random random(9);
  int close = 0, pairs = 0;
  for (int i = 0; i < 16; ++i) {
    const auto any = [&] {
      switch (i % 4) {
        case 0:
          return bowl(random.in(0.7, 0.9), 1, 6, 24);
        case 1: {
          const double inner = random.in(0.4, 0.8);
          return ring(inner, 1, random.in(0.2, 0.6));
        }
        case 2:
          return torus(0.7, random.in(0.15, 0.3), 24, 12);
        default:
          return bumpy_ball(1, 0.15, random.in(0, turn));
      }
    };
    const Shape a(any()), b(any());
    const Pose pose_a{random.rotation(), random.vec(-1, 1)};
    const Pose pose_b{random.rotation(), pose_a.translation + random.vec_of_length(0, 0.9)};
    if (!collide(a, pose_a, b, pose_b, Vec3::Zero())) continue;
    CAPTURE(i);
    const DepthBounds bounds = penetration_depth(a, pose_a, b, pose_b, {.most_boxes = 4000});
    check_promise(a, pose_a, b, pose_b, bounds, random);
    CHECK(bounds.boxes <= 4000);
    ++pairs;
    close += bounds.lower >= 0.95 * bounds.upper * (1 - 1e-9);
    CHECK(bounds.lower >= 0.6 * bounds.upper);
    const DepthBounds exchanged = penetration_depth(b, pose_b, a, pose_a, {.most_boxes = 4000});
    CHECK(exchanged.lower == bounds.lower);
    CHECK(exchanged.upper == bounds.upper);
    CHECK(exchanged.translation == -bounds.translation);
  }
  CHECK(pairs >= 12);
  CHECK(close >= pairs - 2);
}

TEST_CASE("penetration: more boxes, better bounds; none, those of the distance") {
  const Shape a(bumpy_ball(1, 0.15, 0.5)), b(bumpy_ball(0.8, 0.15, 2));
  const Pose pose_b = Pose::from(Quat(0.9, 0.1, 0.3, 0.2), {0.1, 0.05, 0});
  const PairAnswer known = NarrowPhase().solve(a, {}, b, pose_b, Request::distance);
  REQUIRE(known.status == Status::inexact);
  const DepthBounds without = penetration_depth(a, {}, b, pose_b, {.most_boxes = 0});
  CHECK(std::abs(without.upper + known.signed_distance) < 1e-9);
  CHECK(std::abs(without.lower + known.signed_distance + known.error_bound) < 1e-9);
  CHECK(without.boxes == 0);
  DepthBounds before = without;
  Random random(3);
  for (const std::size_t boxes : {100u, 1000u, 10'000u}) {
    const DepthBounds now = penetration_depth(a, {}, b, pose_b, {.gap = 0.01, .most_boxes = boxes});
    CHECK(now.lower >= before.lower);
    CHECK(now.upper <= before.upper);
    CHECK(now.boxes <= boxes);
    check_promise(a, {}, b, pose_b, now, random, 100);
    before = now;
  }
  CHECK(before.lower >= 0.98 * before.upper);
}

TEST_CASE("penetration: surfaces count where they are; hollows are left on either side") {
  Random random(12);
  // A surface that is in a solid slab to a depth of 0.5.
  Mesh sheet;
  sheet.vertices = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Shape open(sheet), block(ring(0.3, 3, 2, 32));
  const Pose at = Pose::at(2.9, 0, 0);
  const DepthBounds bounds = penetration_depth(block, {}, open, at);
  check_promise(block, {}, open, at, bounds, random, 100);
  CHECK(bounds.upper < 0.61);
  CHECK(bounds.lower > 0.55);
  // The wall of a cup is thin: a body in it is pushed out on the nearer side, even to the inside.
  const Shape cup(ring(0.9, 1, 2, 48)), ball(bumpy_ball(0.2, 0, 0));
  for (const double middle : {0.8, 1.1}) {
    const Pose in_wall = Pose::at(middle, 0, 0);
    const DepthBounds out = penetration_depth(cup, {}, ball, in_wall);
    check_promise(cup, {}, ball, in_wall, out, random, 100);
    CHECK(out.upper < 0.12);
    CHECK((out.translation.x() > 0) == (middle > 1));
  }
  // Two surfaces: the bounds of the distance query, tested.
  const Shape other(sheet);
  const Pose across{Mat3(Eigen::AngleAxisd(1.2, Vec3(1, 0.2, 0.1).normalized())), {0.1, 0.2, 0}};
  const DepthBounds crossing = penetration_depth(open, {}, other, across);
  check_promise(open, {}, other, across, crossing, random, 100);
}

TEST_CASE(
    "penetration: of a convex or round shape a thin wall, a surface and what is not closed keep no more than they "
    "are") {
  Random random(13);
  const Shape ball{Sphere{0.2}}, rod{Capsule{0.2, 0.1}}, die{Box{{0.4, 0.4, 0.4}}};
  const std::vector<Shape> bodies{ball, rod, die};
  // A wall 0.1 thick: out of it on the nearer side, even into the cavity.
  const Shape cup(ring(0.9, 1, 2, 96));
  for (const Shape& body : bodies)
    for (const double middle : {0.8, 1.1}) {
      const Pose at = Pose::at(middle, 0, 0);
      const DepthBounds out = penetration_depth(cup, {}, body, at);
      check_promise(cup, {}, body, at, out, random, 100);
      CHECK(out.upper < 0.14);  // 0.1, and more because of the die's edges in the round cavity
      CHECK((out.translation.x() > 0) == (middle > 1));
    }
  // The same body in the cavity is separated, from the cup as a solid and as a surface.
  Mesh skin = ring(0.9, 1, 2, 96);
  skin.solid = false;
  for (const Shape& body : bodies) CHECK_FALSE(penetration_depth(cup, {}, body, {}).collide);
  for (const Shape& body : bodies) CHECK_FALSE(penetration_depth(Shape(skin), {}, body, {}).collide);
  // Within a closed surface, which has no inside, it is separated; a solid with that surface it must leave.
  Mesh shell = bumpy_ball(1, 0, 0);
  const Shape full(shell);
  shell.solid = false;
  const Shape hollow(shell);
  for (const Shape& body : bodies) {
    CHECK_FALSE(penetration_depth(hollow, {}, body, {}).collide);
    const DepthBounds deep = penetration_depth(full, {}, body, {});
    check_promise(full, {}, body, {}, deep, random, 50);
    CHECK(deep.upper > 1);
    // Through the surface: out on either side, by the shorter translation.
    for (const double middle : {0.9, 1.1}) {
      const Pose through = Pose::at(0, 0, middle);
      const DepthBounds out = penetration_depth(hollow, {}, body, through);
      check_promise(hollow, {}, body, through, out, random, 50);
      CHECK(out.upper < 0.2);
      CHECK((out.translation.z() > 0) == (middle > 1));
    }
  }
  // Without a lid it is not closed: refused as a solid, and as a surface only its triangles count.
  Mesh open = shell;
  std::erase_if(open.triangles, [](const auto& t) { return t[0] == 1; });
  const Shape pot(open);
  open.solid = true;
  CHECK_THROWS_AS(Shape(open), std::invalid_argument);
  CHECK_FALSE(penetration_depth(pot, {}, ball, {}).collide);
  const Pose in_skin = Pose::at(0, 0, 1.1);
  CHECK(penetration_depth(pot, {}, ball, in_skin).upper < 0.2);
}

TEST_CASE("penetration: two surfaces are as deep as they cross, and apart once the one has come through") {
  Random random(14);
  Mesh wall, flag;
  wall.vertices = {{0, -2, -2}, {0, 2, -2}, {0, 2, 2}, {0, -2, 2}};
  flag.vertices = {{-0.3, 0, -0.5}, {0.1, 0, -0.5}, {0.1, 0, 0.5}, {-0.3, 0, 0.5}};
  wall.triangles = flag.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Shape a(wall), b(flag);
  const DepthBounds crossing = penetration_depth(a, {}, b, {});
  check_promise(a, {}, b, {}, crossing, random, 200);
  CHECK(crossing.upper == Approx(0.1).margin(1e-9));
  CHECK(crossing.translation.x() < 0);
  const Pose beyond = Pose::at(-0.11, 0, 0);  // at most 0.01 from it
  CHECK_FALSE(penetration_depth(a, {}, b, beyond).collide);
  CHECK_FALSE(penetration_depth(a, {}, b, Pose::at(0.31, 0, 0)).collide);
}

TEST_CASE("penetration: points in one place, at the origin or not, are separated by next to nothing") {
  const Vec3 zero = Vec3::Zero();
  const Shape points[] = {Sphere{0}, Shape(Convex{{zero}}), Triangle{{zero, zero, zero}},
                          Shape(Mesh{{zero}, {{0, 0, 0}}, false}), HalfSpace{{0, 0, 1}, 0}};
  for (const Shape& a : points)
    for (const Shape& b : points)
      for (const double x : {0.0, 1.0}) {
        if (!a.is_bounded() && !b.is_bounded()) continue;
        const Pose at = Pose::at(x, 0, 0);
        const DepthBounds bounds = penetration_depth(a, at, b, at);
        CAPTURE(name(a.kind()), name(b.kind()), x, bounds.upper);
        CHECK(bounds.collide);
        CHECK(bounds.lower == 0);
        CHECK(bounds.upper > 0);
        CHECK(bounds.upper < 1e-12);
        const Pose moved{at.rotation, at.translation + bounds.translation};
        CHECK_FALSE(NarrowPhase().solve(a, at, b, moved, Request::collide).collide);
      }
}

TEST_CASE("penetration: what is apart has none; bad options are refused") {
  const Shape a(torus(1, 0.3, 24, 12));
  CHECK_FALSE(penetration_depth(a, {}, a, Pose::at(3, 0, 0)).collide);
  CHECK(penetration_depth(a, {}, a, Pose::at(3, 0, 0)).upper == 0);
  const Pose in = Pose::at(0.3, 0.1, 0.05);
  const auto with = [&](const DepthOptions& options) { return penetration_depth(a, {}, a, in, options); };
  CHECK_THROWS_AS(with({.gap = -0.1}), std::invalid_argument);
  CHECK_THROWS_AS(with({.gap = std::nan("")}), std::invalid_argument);
  CHECK_THROWS_AS(penetration_depth(a, {Mat3::Zero(), Vec3::Zero()}, a, in), std::invalid_argument);
}

TEST_CASE("penetration: a limit ends the search with bounds that hold, the closer the later it is reached") {
  const Shape a(torus(1, 0.3, 24, 12));
  const Pose in = Pose::at(0.3, 0.1, 0.05);
  int looks = 0, most = 0;
  const WorkLimit limit{.ended = [&] { return ++looks > most; }};
  const auto until = [&](int looks_allowed) {
    looks = 0, most = looks_allowed;
    return penetration_depth(a, {}, a, in, {.limit = &limit});
  };
  const DepthBounds whole = penetration_depth(a, {}, a, in);
  CHECK_FALSE(whole.incomplete);
  const DepthBounds not_reached = until(1 << 30);
  const int all = looks;
  CHECK_FALSE(not_reached.incomplete);
  CHECK(not_reached.lower == whole.lower);
  CHECK(not_reached.translation == whole.translation);
  CHECK_THROWS_AS(until(0), WorkStopped);
  Random random(21);
  DepthBounds before;
  before.upper = std::numeric_limits<double>::infinity();
  int told = 0, proven = 0;
  for (int k = 1; k < 20; ++k) {
    CAPTURE(k, all);
    try {
      const DepthBounds bounds = until(k * (all / 20));
      CHECK(bounds.incomplete);
      check_promise(a, {}, a, in, bounds, random, 40);
      CHECK(bounds.lower >= before.lower);
      CHECK(bounds.upper <= before.upper);
      CHECK(bounds.boxes <= whole.boxes);
      proven += bounds.boxes > 0 && bounds.lower > before.lower ? 1 : 0;
      before = bounds;
      ++told;
    } catch (const WorkStopped&) {
      CHECK(told == 0);  // later there is always a result
    }
  }
  CHECK(told >= 15);
  CHECK(proven >= 3);
  CHECK(before.upper >= whole.upper);
  CHECK(before.lower <= whole.lower);
}
