// Slivers and long thin hulls beside shapes with flat faces a thousand times smaller and more, judged by the reference:
// the rounding of the large one is noticeable relative to the small one's size, and to the thin one's width.
#include <algorithm>
#include <cmath>
#include <vector>

#include "catch.h"
#include "convex/feature_normals.h"
#include "convex/gjk.h"
#include "random_pairs.h"
#include "reference.h"

using namespace tandem;
using namespace tandem::test;

namespace {

constexpr double allowed_error = 1e-12;  ///< relative to the extent of a pair: distances and points
constexpr double loose = 3e-12;          ///< the same: the vector between the points against distance x normal

double small(Random& r, double least, double most) { return std::pow(10.0, -r.in(least, most)); }

Shape needle(Random& r) {
  if (r.once_in(2)) {
    const Vec3 p = r.vec(-1, 1), q = r.vec(-1, 1);
    const Vec3 on_line = p + r.in(-0.5, 1.5) * (q - p);
    const double height = small(r, 5, 16);
    return Shape(Triangle{{p, q, Vec3(on_line + height * r.direction())}});
  }
  const Vec3 stretch{small(r, 4, 8), r.once_in(3) ? 1 : small(r, 4, 8), 1};
  Convex c;
  for (int n = 3 + r.below(12); n > 0; --n) c.vertices.push_back(r.vec(-1, 1).cwiseProduct(stretch));
  return Shape(c);
}

Shape speck(Random& r) {
  const double size = small(r, 3, 8);
  const Vec3 stretch{1, r.once_in(2) ? 1 : small(r, 0, 8), r.once_in(2) ? 1 : small(r, 0, 8)};
  const auto point = [&] { return Vec3(size * r.vec(-1, 1).cwiseProduct(stretch)); };
  switch (r.below(4)) {
    case 0:
      return Shape(Box{size * stretch});
    case 1:
      return Shape(Capsule{size * small(r, 0, 8), size});
    case 2:
      return Shape(Triangle{{point(), point(), point()}});
    default: {
      Convex c;
      for (int n = 4 + r.below(8); n > 0; --n) c.vertices.push_back(point());
      return Shape(c);
    }
  }
}

void check(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb) {
  const PairAnswer answer = NarrowPhase().solve(a, pa, b, pb, Request::distance);
  const reference::Truth truth = reference::signed_distance(a, pa, b, pb);
  const double unit = a.size() + b.size() + (pb.translation - pa.translation).norm();
  CHECK(std::abs(answer.signed_distance - truth.signed_distance) <= truth.error + allowed_error * unit);
  CHECK((answer.point_b - answer.point_a - answer.signed_distance * answer.normal).norm() <= loose * unit);
  const auto off = [](const Shape& s, const Pose& pose, const Vec3& p) {
    return std::abs(reference::signed_distance(s, pose, Shape(Sphere{0}), {Mat3::Identity(), p}).signed_distance);
  };
  CHECK(off(a, pa, answer.point_a) <= allowed_error * unit);
  CHECK(off(b, pb, answer.point_b) <= allowed_error * unit);
  if (std::abs(truth.signed_distance) > allowed_error * unit)
    CHECK(NarrowPhase().solve(a, pa, b, pb, Request::collide).collide == (truth.signed_distance <= 0));
}

}  // namespace

TEST_CASE("slivers and long thin hulls with something much smaller: apart, touching, overlapping") {
  for (std::uint64_t seed = 0; seed < 1200; ++seed) {
    CAPTURE(seed);
    Random r(7000 + seed);
    const Shape a = needle(r), b = speck(r);
    const Pose pose_a{r.rotation(), Vec3::Zero()};
    Pose pose_b{r.rotation(), r.vec_of_length(0, 1)};
    // Within a given gap.
    const double sign = r.once_in(8) ? 0.0 : r.sign(), gap = sign == 0 ? 0.0 : sign * small(r, 3, 14);
    for (int i = 0; i < 2; ++i) {
      const reference::Truth t = reference::signed_distance(a, pose_a, b, pose_b);
      pose_b.translation += (gap - t.signed_distance) * t.normal;
    }
    check(a, pose_a, b, pose_b);
    check(b, pose_b, a, pose_a);
  }
}

TEST_CASE("a point beside a triangle's corner: the whole triangle is behind the plane through its nearest point") {
  // The distances from the two edges there are the same number. Of every five triangles two are slivers, one has two
  // equal corners, one two corners near each other, and one three in a line.
  for (std::uint64_t seed = 0; seed < 100000; ++seed) {
    CAPTURE(seed);
    Random r(23000 + seed);
    const Vec3 stretch{1, small(r, 0, 10), small(r, 0, 10)};
    Triangle t;
    for (Vec3& corner : t.vertices) corner = r.vec(-1, 1).cwiseProduct(stretch);
    if (seed % 5 == 2) t.vertices[2] = t.vertices[1];
    if (seed % 5 == 3) t.vertices[2] = t.vertices[0] + small(r, 3, 13) * r.direction();
    if (seed % 5 == 4) t.vertices[2] = (t.vertices[0] + t.vertices[1]) / 2;
    const Vec3 edge = t.vertices[1] - t.vertices[0];
    const Vec3 across = edge.cross(t.vertices[2] - t.vertices[0]);
    const Vec3 above = seed % 5 < 2 ? Vec3(across.stableNormalized()) : edge.unitOrthogonal();
    const Vec3& corner = t.vertices[static_cast<std::size_t>(r.below(3))];
    const Pose at{Mat3::Identity(), corner + small(r, -1, 6) * (above + small(r, 0, 12) * r.direction())};
    const PairAnswer answer = NarrowPhase().solve(Shape(t), {}, Shape(Sphere{0}), at, Request::distance);
    double separation = infinity;
    for (const Vec3& v : t.vertices) separation = std::min(separation, answer.normal.dot(at.translation - v));
    REQUIRE(answer.signed_distance - separation <= allowed_error * (3 + at.translation.norm()));
  }
}

TEST_CASE(
    "a solid mesh and a triangle at its corner: the normal separates them, though pairs of triangles are as near") {
  Mesh solid;
  solid.solid = true;
  solid.vertices = {{0.09375, 0.5625, -2.8401474685135104e-07},
                    {0.09375, -0.375, 2.8401474685135104e-07},
                    {-0.0625, 0.1875, 1.8934316456756736e-07},
                    {0.0, -0.75, -2.8401474685135104e-07}};
  solid.triangles = {{0, 3, 2}, {0, 1, 3}, {0, 2, 1}, {3, 1, 2}};
  const Triangle triangle{{Vec3{-0.3707296913378072, 0.00031640785051935345, -0.00011660307649996737},
                           Vec3{-0.35713805153921363, 0.0003059842810810612, -4.775980480040405e-05},
                           Vec3{-0.012376997306943804, 0.00028328857985270305, -0.0004259855130095654}}};
  Pose a, b;
  a.rotation << 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0;
  a.translation = Vec3{0.0, 0.0, 0.0};
  b.rotation << 0.03186357511966875, 0.7592804392346971, 0.6499830206829704, -0.997897027860328, 0.06089375801850605,
      -0.022214230166888393, -0.056446739215982145, -0.6479082997075659, 0.7596239864577302;
  b.translation = Vec3{0.09420616325661815, -0.3873776822728992, -0.0001912225582844214};
  const PairAnswer answer = NarrowPhase().solve(Shape(solid), a, Shape(triangle), b, Request::distance);
  CHECK_FALSE(answer.collide);
  for (const Vec3& p : solid.vertices) CHECK(answer.normal.dot(a * p - answer.point_a) <= 1e-10);
  for (const Vec3& p : triangle.vertices) CHECK(answer.normal.dot(b * p - answer.point_b) >= -1e-10);
}

TEST_CASE("a point as near to all three sides of a triangle, to rounding: the order of corners changes nothing") {
  const Vec3 a{-0.12476639148494104, 0.7955363083628916, 0.5929210146656709},
      b{0.45477720530873317, -0.6443322907279271, -0.614828100087236},
      c{-0.12476639161323125, 0.7955363082218257, 0.5929210145807549},
      p{-0.2200398039012152, 1.1998991754327921, 0.06512554057553144};
  std::array<Vec3, 3> corners{a, b, c};
  const std::array<std::array<std::size_t, 3>, 6> orders{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  for (const auto& order : orders) {
    CAPTURE(order[0], order[1], order[2]);
    const Triangle t{{corners[order[0]], corners[order[1]], corners[order[2]]}};
    const PairAnswer answer =
        NarrowPhase().solve(Shape(t), {}, Shape(Sphere{0}), {Mat3::Identity(), p}, Request::distance);
    for (const Vec3& v : corners) CHECK(answer.normal.dot(p - v) >= answer.signed_distance - allowed_error);
  }
}

TEST_CASE("slivers and specks that nearly touch: GJK's direction is the one that separates by its lower bound") {
  // A nearest point no farther than rounding has none; nor has one to which the last step led back.
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    CAPTURE(seed);
    Random r(17000 + seed);
    const Shape a = needle(r), b = speck(r);
    const ConvexView in_a = view(a), in_b = view(b);
    MinkowskiDifference d{in_a, in_b, relative({}, {r.rotation(), r.vec_of_length(0, 1)})};
    for (int i = 0; i < 3; ++i) {
      const GjkResult found = gjk(d, tolerance::ends_on_polytopes);
      REQUIRE(std::abs(found.direction.norm() - 1) <= 4 * epsilon);
      REQUIRE(found.lower <= found.upper + 8 * epsilon * d.scale());
      REQUIRE(separation_along(d, found.direction) >= found.lower - 8 * epsilon * d.scale());
      d.pose.translation += (small(r, 13, 20) - found.upper) * found.direction;
    }
  }
}

TEST_CASE("a hull 1e-8 wide around a point 1e-5 of that inside: no verdict by a simplex that is flat") {
  // The simplex of four points seemed to contain the origin; moved out by the depth, they collided.
  const Shape hull(
      Convex{{Vec3(2e-08, -1e-07, 0.4), Vec3(7.5e-10, -2.3e-07, -0.93), Vec3(-2e-08, 1e-07, -0.9),
              Vec3(2e-08, 1e-07, -0.2), Vec3(-1.57e-08, -1.23e-07, 0.974), Vec3(1.42e-08, 3.22e-07, 0.725)}});
  const Shape ball(Sphere{1.749236090136385e-12});
  Pose pose;
  pose.rotation << 0.20007152452361765, 0.9603326596704589, -0.19424872675273386, 0.9178788610340669,
      -0.2530631706204707, -0.30570807667171507, -0.3427386490339249, -0.11713331911022393, -0.932099782218955;
  const PairAnswer in = NarrowPhase().solve(hull, pose, ball, {}, Request::distance);
  const Pose out{Mat3::Identity(), (2e-12 - in.signed_distance) * in.normal};
  CHECK(in.signed_distance < -1e-9);
  CHECK(!NarrowPhase().solve(hull, pose, ball, out, Request::collide).collide);
}

TEST_CASE("a segment through a triangle 1e5 times smaller: no depth of the segment's length") {
  const Shape segment(Convex{{Vec3(-0.9333925247192383, 0.26656341552734375, -0.22878170013427734),
                              Vec3(0.7527217864990234, 0.8968276977539063, 0.811549186706543),
                              Vec3(-1.1725040983621406, 0.17718425343173203, -0.3763133080488631)}});
  const Shape speck(
      Triangle{{Vec3(-4.862315152890818e-06, -1.8225980346031376e-06, -1.40752122094964e-06),
                Vec3(-3.3648e-06, 7.9962e-06, -6.076e-06), Vec3(-3.8882462e-06, 4.5640692e-06, -4.4441423e-06)}});
  Pose pose_a, pose_b;
  pose_a.rotation << -0.05735931332716149, 0.261687588736702, -0.9634466851236799, -0.29957307232564473,
      0.9160533449193283, 0.2666500395640027, 0.9523475644490359, 0.3039175466525105, 0.02585036411172148;
  pose_b.rotation << 0.21003703302627086, -0.3349224901116841, -0.9185376259984728, -0.21182418921564689,
      -0.9327681552488132, 0.2916746156539157, -0.9544710355063977, 0.13330601701016526, -0.2668605407478415;
  pose_b.translation = {-0.10784643042318005, 0.6318257701468232, 0.06804698631110115};
  check(segment, pose_a, speck, pose_b);
}
