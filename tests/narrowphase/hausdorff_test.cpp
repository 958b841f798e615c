// The Hausdorff distance of two surfaces, compared with closed forms and with sampled points.
#include "tandem/narrowphase/hausdorff.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "catch.h"
#include "mesh_samples.h"
#include "random.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/work_limit.h"

using namespace tandem;
using namespace tandem::test;
using reference::Random;

namespace {

Shape surface(Mesh mesh) {
  mesh.solid = false;
  return Shape(std::move(mesh));
}

double distance_to(const Shape& shape, const Pose& pose, const Vec3& p) {
  return NarrowPhase().solve(shape, pose, Sphere{0}, {Mat3::Identity(), p}, Request::distance).signed_distance;
}

/// The largest distance of sampled points of one surface from the other, n rows of them on each triangle, and the
/// sampling distance.
struct Sampled {
  double most = 0, apart = 0;
};
Sampled sampled(const Shape& from, const Pose& pose, const Shape& to, const Pose& pose_to, int n) {
  Sampled found;
  for (const auto& t : from.triangles()) {
    const Vec3 a = pose * from.vertices()[t[0]], b = pose * from.vertices()[t[1]], c = pose * from.vertices()[t[2]];
    found.apart = std::max(found.apart, std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()}) / n);
    for (int i = 0; i <= n; ++i)
      for (int j = 0; i + j <= n; ++j) {
        const Vec3 p = a + static_cast<double>(i) / n * (b - a) + static_cast<double>(j) / n * (c - a);
        found.most = std::max(found.most, distance_to(to, pose_to, p));
      }
  }
  return found;
}

void check_point(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                 const HausdorffBounds& bounds) {
  CHECK((0 <= bounds.lower && bounds.lower <= bounds.upper));
  CHECK(std::abs((bounds.point - bounds.nearest).norm() - bounds.lower) < 1e-9);
  CHECK(std::abs(distance_to(bounds.of_a ? a : b, bounds.of_a ? pose_a : pose_b, bounds.point)) < 1e-9);
  CHECK(std::abs(distance_to(bounds.of_a ? b : a, bounds.of_a ? pose_b : pose_a, bounds.point) - bounds.lower) < 1e-9);
}

}  // namespace

TEST_CASE("Hausdorff: closed forms") {
  const Shape cube = surface(box_mesh({2, 2, 2}, 3)), small = surface(box_mesh({1, 1, 1}, 2));
  for (const double gap : {0.0, 1e-3}) {
    // From corner to corner; in the other direction it is from face to face.
    const HausdorffBounds inside = hausdorff_distance(cube, {}, small, {}, {.gap = gap});
    CHECK(std::abs(inside.lower - std::sqrt(0.75)) < 1e-9);
    CHECK(inside.upper <= std::sqrt(0.75) * (1 + gap) + 1e-9);
    CHECK(inside.of_a);
    // The same moved.
    const HausdorffBounds moved = hausdorff_distance(cube, {}, cube, Pose::at(0.25, 0, 0), {.gap = gap});
    CHECK((moved.lower <= 0.25 + 1e-9 && moved.upper >= 0.25 - 1e-9 && moved.upper - moved.lower <= gap + 1e-9));
  }
  CHECK(hausdorff_distance(cube, {}, cube, {}, {.least = 0}).upper < 1e-9);
  // The same surface, triangulated in two ways.
  Mesh mirrored = box_mesh({2, 2, 2}, 1);
  for (Vec3& v : mirrored.vertices) v.x() = -v.x();
  for (auto& t : mirrored.triangles) std::swap(t[1], t[2]);
  const HausdorffBounds none = hausdorff_distance(surface(box_mesh({2, 2, 2}, 1)), {}, surface(mirrored), {});
  CHECK((none.lower < 1e-9 && none.upper <= 1e-4 * 2 * std::sqrt(3.0) * (1 + 1e-9) && none.parts < 1'000'000));
  CHECK(std::abs(none.point.cwiseAbs().maxCoeff() - 1) < 1e-12);
  const Shape ring = surface(torus(1, 0.3, 24, 12)), thin = surface(torus(1, 0.1, 24, 12));
  const HausdorffBounds tubes = hausdorff_distance(ring, {}, thin, {}, {.gap = 1e-4});
  CHECK((tubes.lower > 0.2 - 1e-9 && tubes.upper < 0.2 * (1 + 2e-4)));
  // A triangle and a point of a larger one.
  const Shape flat = Triangle{{Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(0, 4, 0)}};
  const HausdorffBounds corner = hausdorff_distance(flat, {}, flat, Pose::at(0, 0, 1.5));
  CHECK(std::abs(corner.lower - 1.5) < 1e-9);
  // One corner is on the other surface, which is equally far from the two others.
  const HausdorffBounds long_sides =
      hausdorff_distance(flat, {}, Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}}, {});
  CHECK(std::abs(long_sides.lower - 3) < 1e-9);
  CHECK(std::abs(long_sides.upper - 3) < 4e-3);
}

TEST_CASE("Hausdorff: points all over both surfaces lie within the bounds, near the lower one") {
  Random random(31);
  const Shape shapes[] = {surface(torus(1, 0.3, 10, 6)), surface(box_mesh({1.5, 1, 2}, 2)),
                          Shape(torus(0.8, 0.2, 8, 5)), surface(box_mesh({1, 1, 1}, 1))};
  for (int i = 0; i < 12; ++i) {
    const Shape &a = shapes[i % 4], &b = shapes[(i / 4 + i) % 4];
    const double far = i % 3 == 0 ? 0 : i % 3 == 1 ? 1 : 5;
    const Pose pose_a{random.rotation(), random.vec(-1, 1)};
    const Pose pose_b{random.rotation(), pose_a.translation + far * random.direction()};
    const HausdorffBounds bounds = hausdorff_distance(a, pose_a, b, pose_b, {.gap = 1e-4});
    check_point(a, pose_a, b, pose_b, bounds);
    CHECK(bounds.upper - bounds.lower <= 1e-4 * bounds.upper + 1e-9);
    // Distances of a solid's points are those of its surface here, taken without a sign.
    const Shape bare_a =
        surface({{a.vertices().begin(), a.vertices().end()}, {a.triangles().begin(), a.triangles().end()}});
    const Shape bare_b =
        surface({{b.vertices().begin(), b.vertices().end()}, {b.triangles().begin(), b.triangles().end()}});
    const Sampled of_a = sampled(bare_a, pose_a, bare_b, pose_b, 8), of_b = sampled(bare_b, pose_b, bare_a, pose_a, 8);
    CAPTURE(i, bounds.lower, bounds.upper, of_a.most, of_b.most);
    CHECK(std::max(of_a.most, of_b.most) <= bounds.upper + 1e-9);
    CHECK(std::max(of_a.most + of_a.apart, of_b.most + of_b.apart) >= bounds.lower - 1e-9);
    for (std::size_t most = 4; most < bounds.parts; most += most / 4 + 1) {
      const HausdorffBounds early = hausdorff_distance(a, pose_a, b, pose_b, {.gap = 0, .most_parts = most});
      CHECK((early.lower <= bounds.upper && early.upper >= bounds.lower));
    }
    const HausdorffBounds exchanged = hausdorff_distance(b, pose_b, a, pose_a, {.gap = 1e-4});
    CHECK(exchanged.lower == bounds.lower);
    CHECK(exchanged.upper == bounds.upper);
    CHECK(exchanged.point == bounds.point);
  }
}

TEST_CASE("Hausdorff: tolerances, parts and limits end it; what it cannot answer is refused") {
  const Shape a = surface(torus(1, 0.3, 24, 12)), b = surface(torus(1.1, 0.2, 20, 10));
  const Pose at = Pose::from(Quat(0.9, 0.3, 0.1, 0), {0.2, 0.1, 0});
  const HausdorffBounds close = hausdorff_distance(a, {}, b, at, {.gap = 1e-6});
  const HausdorffBounds rough = hausdorff_distance(a, {}, b, at, {.tolerance = 0.1, .gap = 0});
  CHECK(rough.parts < close.parts);
  CHECK(rough.upper - rough.lower <= 0.1 + 1e-9);
  CHECK((rough.lower <= close.upper && close.lower <= rough.upper));
  const HausdorffBounds few = hausdorff_distance(a, {}, b, at, {.most_parts = 100});
  CHECK(few.parts <= 110);
  CHECK((few.lower <= close.upper && close.lower <= few.upper));
  const WorkLimit limit{.ended = [] { return true; }};
  CHECK_THROWS_AS(hausdorff_distance(a, {}, b, at, {.limit = &limit}), WorkStopped);
  CHECK_THROWS_AS(hausdorff_distance(a, {}, Sphere{1}, at), std::invalid_argument);
  CHECK_THROWS_AS(hausdorff_distance(a, {}, b.rounded(0.1), at), std::invalid_argument);
  CHECK_THROWS_AS(hausdorff_distance(a, {}, b, at, {.tolerance = -1}), std::invalid_argument);
  CHECK_THROWS_AS(hausdorff_distance(a, {}, b, at, {.gap = 2}), std::invalid_argument);
}
