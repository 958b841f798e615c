// Distances of triangles and boxes by axes and edges.
#include "triangles/triangle_distance.h"

#include "catch.h"
#include "pair_classes.h"
#include "random_pairs.h"
#include "reference.h"

using namespace tandem;
using namespace tandem::test;

namespace {

struct AnsweredTally {
  int pairs = 0, answered = 0;
};

/// Compares the answer by axes and edges with the reference; pairs left to GJK are counted.
void check(const reference::PosedPair& p, AnsweredTally& tally) {
  const ConvexView a = view(p.a), b = view(p.b);
  const MinkowskiDifference d{a, b, relative(p.pose_a, p.pose_b)};
  ++tally.pairs;
  const auto answer = triangle_distance(d);
  if (!answer) return;
  ++tally.answered;
  const double size = reference::size(p);
  const reference::Truth truth = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
  CHECK(answer->signed_distance >= truth.signed_distance - 1e-13 * size);
  CHECK(answer->signed_distance <= truth.signed_distance + truth.error + 1e-13 * size);
  CHECK(std::abs(answer->normal.norm() - 1) < 1e-14);
  CHECK((answer->point_b - answer->point_a - answer->signed_distance * answer->normal).norm() <= 1e-12 * size);
  for (const auto& [shape, point] : {std::pair{&p.a, p.pose_a * answer->point_a}, {&p.b, p.pose_a * answer->point_b}}) {
    const Pose& pose = shape == &p.a ? p.pose_a : p.pose_b;
    const double off =
        reference::signed_distance(*shape, pose, Shape(Sphere{0}), {Mat3::Identity(), point}).signed_distance;
    CHECK(off <= 1e-11 * size + 1e-15 * (p.pose_a.translation.norm() + p.pose_b.translation.norm()));
  }
  // With a limit that is exceeded, it is a separation along the normal.
  const double beyond = 0.5 * answer->signed_distance;
  if (!(beyond > 0)) return;
  const auto early = triangle_distance(d, beyond);
  REQUIRE(early);
  CHECK(early->signed_distance > beyond);
  const double along = reference::separation(p.a, p.pose_a, p.b, p.pose_b, p.pose_a.rotation * early->normal);
  CHECK(early->signed_distance <= along + 1e-13 * size);
}

}  // namespace

TEST_CASE("triangles with triangles and boxes by their axes: right, and seldom left to others") {
  for (const ShapeKind other : {ShapeKind::box, ShapeKind::triangle})
    for (const reference::PairClass pair_class : reference::all_pair_classes) {
      AnsweredTally tally;
      CAPTURE(name(other), name(pair_class));
      for (std::uint64_t i = 0; i < 120; ++i)
        check(reference::make_pair({other}, {ShapeKind::triangle}, pair_class, 7000 + i), tally);
      CAPTURE(tally.answered);
      CHECK(tally.answered > (pair_class == reference::PairClass::hard ? 0.6 : 0.95) * tally.pairs);
    }
}

TEST_CASE("triangles as needles and slivers, up to a hundred thousand times the other's size") {
  Random r(53);
  AnsweredTally tally;
  for (int i = 0; i < 400; ++i) {
    const double length = std::pow(10.0, r.in(0, 5)), width = std::pow(10.0, r.in(-3, 0));
    const Vec3 along = length * r.direction(), aside = width * r.direction(), from = -r.in(0, 1) * along;
    const Shape needle(Triangle{{from, from + along, from + (i % 4 < 2 ? 0.0 : r.in(0, 1)) * along + aside}});
    const Shape other = i % 2 == 0 ? Shape(Box{r.vec(0.3, 1)}) : random_shape(ShapeKind::triangle, r);
    CAPTURE(i, length, width);
    const Pose pose_b = random_pose(r, 1);
    check({other, random_pose(r, 1), needle, pose_b}, tally);
    if (other.kind() == ShapeKind::triangle) check({needle, pose_b, other, random_pose(r, 1)}, tally);
  }
  CAPTURE(tally.answered);
  CHECK(tally.answered > tally.pairs / 2);
}

TEST_CASE("a triangle on edge along a ridge, almost parallel: the product of the edges is the translation out") {
  Random r(59);
  Pose ridge;  // an edge of the box on top
  ridge.rotation = Eigen::AngleAxisd(0.25 * 3.14159265358979, Vec3::UnitX()).toRotationMatrix();
  const Shape box(Box{{1, 1, 1}});
  const Shape roof(Triangle{{Vec3(-0.5, 0, 0.7), Vec3(0.5, 0, 0.7), Vec3(0, 0.1, -1)}});
  const Shape blade(Triangle{{Vec3(-0.6, 0, 0), Vec3(0.7, 0, 0), Vec3(0.2, 0.1, 2)}});
  AnsweredTally tally;
  for (int i = 0; i < 200; ++i) {
    Pose pose;
    const double angle = std::pow(10.0, r.in(-12, -1));
    pose.rotation = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
    pose.translation = {r.in(-0.1, 0.1), 0, std::sqrt(0.5) - std::pow(10.0, r.in(-6, -2))};
    CAPTURE(i, angle);
    check({box, ridge, blade, pose}, tally);
    pose.translation.z() -= std::sqrt(0.5) - 0.7;
    check({roof, {}, blade, pose}, tally);
  }
  CHECK(tally.answered > tally.pairs / 4);
}

TEST_CASE("a needle of a triangle beside a box 72,000 times smaller") {
  // Input 2002549 of the fuzz test's pseudo-random bytes: the expanding simplex was 1.4e-7 off.
  const Shape box(Box{Vec3(0.36083988410822021, 0.5, 0.5)});
  Pose pose_a, pose_b;
  pose_a.rotation << 0.44354390522431208, 0.59184217397290007, 0.67304654017786758, 0.62719628825533413,
      0.33147074915437635, -0.70480632691099498, -0.64022934963737654, 0.73474484248755911, -0.22417938420121031;
  pose_a.translation = {-43.893039396314194, -0.29999999999999999, 0};
  const Shape needle(
      Triangle{{Vec3(0, 0, 1), Vec3(72091.625234849998, 0, -9.8091132119575344e-11), Vec3(0.25, 0, -1.5)}});
  pose_b.rotation << 0.9999999999999859, -1.6333494896229412e-07, -3.9834886429338689e-08, 1.6333494368143698e-07,
      0.99999999999997791, -1.3256861711822374e-07, 3.9834908082426116e-08, 1.3256861061179293e-07, 0.99999999999999045;
  pose_b.translation = {-44.087943998657906, -0.84973595804969815, 1.8552411888763674};
  const PairAnswer answer = NarrowPhase().solve(box, pose_a, needle, pose_b, Request::distance);
  CHECK(std::abs(answer.signed_distance - 0.35897301932214842) < 1e-10);
}
