// Shapes with rounding: a core with a radius about each point.
#include <cmath>
#include <span>
#include <stdexcept>
#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "random_pairs.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/several_pairs.h"
#include "tandem/narrowphase/shape_makers.h"

using namespace tandem;
using reference::Random;

namespace {

constexpr double exact = 1e-12;  // relative to the extent of the shapes and the translation between them

struct RoundedPair {
  Shape a;
  Pose pose_a;
  Shape b;
  Pose pose_b;

  double scale() const { return a.size() + b.size() + (pose_b.translation - pose_a.translation).norm(); }
  PairAnswer distance() const { return NarrowPhase().solve(a, pose_a, b, pose_b, Request::distance); }
  bool collide() const { return NarrowPhase().solve(a, pose_a, b, pose_b, Request::collide).collide; }
  PairAnswer contacts(std::vector<Contact>& found, double margin = 0) const {
    return NarrowPhase({.margin = margin}).solve(a, pose_a, b, pose_b, Request::contacts, &found);
  }
};

Pose random_pose(Random& random, double far) {
  const auto number = [&] { return random.in(-1, 1); };
  const Quat q{number(), number(), number(), number() + 2};
  return Pose::from(q.normalized(), far * Vec3{number(), number(), number()});
}

std::vector<Shape> cores() {
  return {Shape(Box{{1, 0.6, 0.3}}),
          Shape(Cylinder{0.4, 1}),
          Shape(Cone{0.5, 1}),
          Shape(Ellipsoid{{0.5, 0.3, 0.2}}),
          Shape(Capsule{0.2, 0.7}),
          Shape(Sphere{0.3}),
          Shape(Convex{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.5, 0.5, 0.6}}}),
          Shape(Triangle{{Vec3{0, 0, 0}, Vec3{1, 0, 0.2}, Vec3{0.1, 0.8, 0}}})};
}

}  // namespace

TEST_CASE("rounding: a point, a segment and a triangle without area are a sphere and capsules") {
  Random random(7);
  const Shape sphere(Sphere{0.25}), capsule(Capsule{0.25, 2});
  const Shape point = Shape(Convex{{{0, 0, 0}}}).rounded(0.25);
  const Shape segment = Shape(Convex{{{0, 0, -1}, {0, 0, 1}}}).rounded(0.25);
  const Shape flat = Shape(Triangle{{Vec3{0, 0, -1}, Vec3{0, 0, 1}, Vec3{0, 0, 0.5}}}).rounded(0.25);
  const Shape mesh = Shape(Mesh{{{0, 0, -1}, {0, 0, 1}, {0, 0, 0.5}}, {{0, 1, 2}}, false}).rounded(0.25);
  for (int i = 0; i < 200; ++i)
    for (const Shape& other : cores()) {
      const Pose at = random_pose(random, 0.1), other_at = random_pose(random, 2);
      const auto alike = [&](const Shape& x, const Shape& y) {
        const RoundedPair p{x, at, other, other_at}, q{y, at, other, other_at};
        const double of_p = p.distance().signed_distance, of_q = q.distance().signed_distance;
        // The cores' depth is the capsule's minus its radius, where they overlap.
        CHECK(std::abs(of_p - of_q) <= exact * p.scale());
        if (std::abs(of_q) > exact * p.scale()) CHECK(p.collide() == q.collide());
      };
      alike(point, sphere);
      alike(segment, capsule);
      alike(flat, capsule);
      alike(mesh, capsule);
    }
}

TEST_CASE("rounding: a distance is the cores' less the radii, and witness points lie that far from the cores") {
  Random random(11);
  const auto shapes = cores();
  for (int i = 0; i < 40; ++i)
    for (const Shape& x : shapes)
      for (const Shape& y : shapes) {
        const double ra = random.in(0, 0.3), rb = i % 2 == 0 ? 0 : random.in(0, 0.3);
        const Pose pose_a = random_pose(random, 0.2), pose_b = random_pose(random, 1.5);
        const RoundedPair core{x, pose_a, y, pose_b}, pair{x.rounded(ra), pose_a, y.rounded(rb), pose_b};
        const PairAnswer of_core = core.distance(), r = pair.distance();
        CHECK(std::abs(r.signed_distance - (of_core.signed_distance - ra - rb)) <= exact * pair.scale());
        CHECK(r.collide == (r.signed_distance <= 0));
        CHECK(pair.collide() == r.collide);
        CHECK((r.point_a - of_core.point_a - ra * of_core.normal).norm() <= exact * pair.scale());
        CHECK(((r.point_b - r.point_a) - r.signed_distance * r.normal).norm() <= 1e-9 * pair.scale());
        // A translation by the depth separates, a shorter one does not.
        if (r.signed_distance >= 0) continue;
        RoundedPair moved = pair;
        moved.pose_b.translation += -(r.signed_distance - 1e-9) * r.normal;
        CHECK(moved.distance().signed_distance >= -1e-9 * pair.scale());
        moved.pose_b.translation = pose_b.translation - 0.99 * r.signed_distance * r.normal;
        CHECK(moved.collide());
      }
}

TEST_CASE("rounding: contacts are as deep as the distance says, on the rounded surfaces, and swap") {
  Random random(13);
  const auto shapes = cores();
  for (int i = 0; i < 40; ++i)
    for (const Shape& x : shapes)
      for (const Shape& y : shapes) {
        const RoundedPair pair{x.rounded(0.1), random_pose(random, 0.2), y.rounded(0.05), random_pose(random, 1.2)};
        std::vector<Contact> found, swapped;
        const PairAnswer r = pair.contacts(found, 0.02), d = pair.distance();
        CHECK(r.collide == d.collide);
        CHECK(found.empty() == (d.signed_distance > 0.02));
        double deepest = -1e300;
        for (const Contact& c : found) deepest = std::max(deepest, c.depth);
        if (!found.empty()) CHECK(std::abs(deepest + d.signed_distance) <= 1e-9 * pair.scale());
        RoundedPair(RoundedPair{pair.b, pair.pose_b, pair.a, pair.pose_a}).contacts(swapped, 0.02);
        REQUIRE(swapped.size() == found.size());
        for (std::size_t k = 0; k < found.size(); ++k) CHECK(swapped[k].depth == Approx(found[k].depth).margin(1e-12));
      }
}

TEST_CASE("rounding: a thick box lies on a half-space with all four corners") {
  const Shape box = Shape(Box{{1, 2, 0.5}}).rounded(0.1), ground(HalfSpace{{0, 0, 1}, 0});
  std::vector<Contact> found;
  const RoundedPair pair{ground, Pose{}, box, Pose::at(0, 0, 0.34)};
  const PairAnswer r = pair.contacts(found);
  CHECK(r.signed_distance == Approx(-0.01).margin(1e-14));
  REQUIRE(found.size() == 4);
  for (const Contact& c : found) {
    CHECK(c.depth == Approx(0.01).margin(1e-14));
    CHECK(c.point.z() == Approx(-0.005).margin(1e-14));
  }
}

TEST_CASE("rounding: meshes with thickness touch where their surfaces are no farther apart than the radii") {
  const Shape plate = Shape(Mesh{{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}, false});
  for (const double gap : {0.05, 0.0999, 0.1001, 0.3}) {
    const RoundedPair pair{plate.rounded(0.06), Pose{}, plate.rounded(0.04), Pose::at(0.1, 0.2, gap)};
    CHECK(pair.collide() == (gap <= 0.1));
    CHECK(pair.distance().signed_distance == Approx(gap - 0.1).margin(1e-12));
    std::vector<Contact> found;
    const PairAnswer r = pair.contacts(found);
    CHECK(r.collide == (gap <= 0.1));
    CHECK(found.empty() == (gap > 0.1));
  }
  // Within a ring the shortest translation of the cores is not long enough: the answer's separates.
  const RoundedPair ball{plate.rounded(0.06), Pose{}, Shape(Sphere{0.5}), Pose::at(0, 0, 0.3)};
  const PairAnswer r = ball.distance();
  CHECK(r.signed_distance == Approx(-0.26).margin(1e-9));
  RoundedPair moved = ball;
  moved.pose_b.translation -= (r.signed_distance - 1e-9) * r.normal;
  CHECK(moved.distance().signed_distance >= -1e-9);
}

TEST_CASE("rounding: a thick box on a mesh is as deep as its radius, and far from one has no contact") {
  const Shape block(test::box_mesh({2, 2, 2})), box = Shape(Box{{1.6, 1.5, 0.6}}).rounded(0.02);
  Mesh open = test::box_mesh({2, 2, 2});
  open.solid = false;
  for (const Shape& mesh : {block, Shape(open)}) {
    const RoundedPair touching{mesh, Pose{}, box, Pose::at(0.1, 0.1, 1.3)};
    const PairAnswer r = touching.distance();
    CHECK(r.signed_distance == Approx(-0.02).margin(1e-12));
    CHECK(r.status == Status::ok);
    const RoundedPair apart{mesh, Pose{}, box, Pose::at(0.1, 0.1, 3)};
    std::vector<Contact> contacts;
    const PairAnswer none = NarrowPhase().solve(mesh, {}, box, apart.pose_b, Request::contacts, &contacts);
    CHECK_FALSE(none.collide);
    CHECK(none.signed_distance >= 0);
    CHECK(contacts.empty());
  }
}

TEST_CASE("rounding: several pairs, bounds, time of impact and refusals know it") {
  const Shape box(Box{{1, 1, 1}}), thick = box.rounded(0.25);
  CHECK(thick.rounded(0.25).rounding() == 0.5);
  CHECK(thick.size() == Approx(std::sqrt(3.0) * 1.5));
  CHECK(thick.bounds(Pose::at(1, 0, 0)).hi.x() == 1.75);
  CHECK(Shape(Sphere{1}).rounded(0.5).radius() == 1.5);
  CHECK(Shape(Sphere{1}).rounded(0.5).mass().volume == Shape(Sphere{1.5}).mass().volume);
  CHECK(Shape(Capsule{1, 2}).rounded(0.5).radius() == 1.5);
  const Shape below(HalfSpace{{0, 0, 1}, -1}), above(HalfSpace{{0, 0, -1}, -1});
  CHECK_FALSE(NarrowPhase().solve(below, {}, above, {}, Request::collide).collide);
  CHECK(NarrowPhase().solve(below.rounded(1), {}, above.rounded(1), {}, Request::collide).collide);
  CHECK_THROWS_WITH(box.rounded(-1), Catch::Contains("rounding"));
  CHECK_THROWS_AS(box.rounded(std::nan("")), std::invalid_argument);
  const NarrowPhase narrow_phase;
  const auto t = narrow_phase.time_of_impact(thick, Pose{}, Vec3::Zero(), thick, Pose::at(5, 0, 0), {-1, 0, 0}, 10);
  REQUIRE(t);
  CHECK(*t == Approx(3.5).margin(1e-11));
  const Shape triangle(Triangle{{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}});
  CHECK_THROWS_WITH(narrow_phase.intersecting_triangles(triangle.rounded(0.1), {}, triangle, {}),
                    Catch::Contains("rounding"));
  std::vector<PlacedPair> pairs;
  const Pose here, there = Pose::at(1.4, 0.1, 0), away = Pose::at(1.6, 0, 0);
  pairs.push_back({&thick, &here, &thick, &there});
  pairs.push_back({&box, &here, &box, &there});
  pairs.push_back({&thick, &here, &box, &away});
  std::vector<std::uint8_t> apart(pairs.size());
  narrow_phase.mark_apart(pairs, apart);
  CHECK(apart == std::vector<std::uint8_t>{0, 1, 0});
}

// The normal of one face leads along the others.
TEST_CASE("a rounded shape in the corner of three faces of a mesh leaves them all, by what it is deep in them") {
  Random r(18);
  const Shape corner = voxel_mesh(test::corner_cells, 1);
  for (int i = 0; i < 600; ++i) {
    const auto [core, half] = test::resting_shape(i, r);
    const double radius = r.in(0.01, 0.1), deep = i % 3 == 0 ? 0 : std::pow(10, r.in(-12, -3));
    const Shape shape = core.rounded(radius);
    const Pose at_corner{r.rotation(), r.vec(-2, 2)};
    const Pose at{at_corner.rotation, at_corner * (Vec3::Constant(1 + radius - deep) + half)};
    const PairAnswer distance = NarrowPhase().solve(corner, at_corner, shape, at, Request::distance);
    CAPTURE(i, deep, distance.signed_distance, distance.error_bound);
    CHECK(-distance.signed_distance <= std::sqrt(3.0) * deep + 1e-11);
    CHECK(-distance.signed_distance + distance.error_bound >= deep - 1e-11);
  }
}
