// Motions and the first contact of rotating bodies.
#include "tandem/narrowphase/motion.h"

#include <cmath>
#include <limits>

#include "catch.h"
#include "mesh_samples.h"
#include "random_pairs.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("a motion is a screw: its ends, its halves, and angles of every size") {
  Random r(3);
  for (int i = 0; i < 300; ++i) {
    Motion m{random_pose(r, 2), random_pose(r, 2)};
    if (i % 3 == 0) {  // small angles
      const double angle = std::pow(10, -r.in(1, 16));
      m.to.rotation = Eigen::AngleAxisd(angle, r.direction()).toRotationMatrix() * m.from.rotation;
    }
    CHECK((pose_at(m, 0).translation - m.from.translation).norm() == 0);
    CHECK((pose_at(m, 1).translation - m.to.translation).norm() == 0);
    CHECK((pose_at(m, std::nextafter(1.0, 0.0)).translation - m.to.translation).norm() < 1e-14);
    CHECK((pose_at(m, std::nextafter(1.0, 0.0)).rotation - m.to.rotation).norm() < 1e-14);
    // Every part of a screw is a screw: the middle of the first half is the quarter.
    const Motion first_half{m.from, pose_at(m, 0.5)};
    CHECK((pose_at(first_half, 0.5).translation - pose_at(m, 0.25).translation).norm() < 1e-13);
    CHECK((pose_at(first_half, 0.5).rotation - pose_at(m, 0.25).rotation).norm() < 1e-13);
    CHECK((pose_at(m, 0.3).rotation * pose_at(m, 0.3).rotation.transpose() - Mat3::Identity()).norm() < 1e-14);
  }
}

TEST_CASE("first touch on motions: analytic answers") {
  const NarrowPhase n;
  const Shape rod = Box{{2, 0.2, 0.2}}, post = Sphere{0.1}, plate = HalfSpace{{0, 0, 1}, 0};
  // A rod that makes a quarter turn about its middle hits a post at its side after asin(0.2 / 0.9).
  Motion quarter;
  quarter.to.rotation = Eigen::AngleAxisd(std::acos(0.0), Vec3::UnitZ()).toRotationMatrix();
  const Pose at = Pose::at(0, 0.9, 0);
  const auto touch = n.time_of_impact(rod, quarter, post, Motion{at, at});
  REQUIRE(touch);
  CHECK(std::abs(touch->t - (1 - std::asin(0.2 / 0.9) / std::acos(0.0))) < 1e-9);
  CHECK_FALSE(n.time_of_impact(rod, quarter, post, Motion{Pose::at(0, 1.2, 0), Pose::at(0, 1.2, 0)}));
  // The same relative to the post: the rod stands, the post moves around it in the opposite direction.
  Motion round{at, at};
  round.to = Pose{quarter.to.rotation.transpose(), quarter.to.rotation.transpose() * at.translation};
  const auto seen = n.time_of_impact(post, round, rod, Motion{});
  REQUIRE(seen);
  CHECK(std::abs(seen->t - touch->t) < 1e-9);
  // A rod over a floor: its end comes down.
  Motion tilt{Pose::at(0, 0, 0.6), Pose::at(0, 0, 0.6)};
  tilt.to.rotation = Eigen::AngleAxisd(std::acos(0.0), Vec3::UnitY()).toRotationMatrix();
  const auto down = n.time_of_impact(rod, tilt, plate, Motion{});
  REQUIRE(down);
  const double angle = std::asin(0.6 / std::hypot(1, 0.1)) - std::atan2(0.1, 1);
  CHECK(std::abs(down->t - angle / std::acos(0.0)) < 1e-9);
  CHECK(std::abs(down->normal.z() + 1) < 1e-9);
  // The floor rotates instead.
  const auto floor = n.time_of_impact(plate, Motion{Pose{}, Pose{tilt.to.rotation.transpose(), Vec3::Zero()}}, rod,
                                      Motion{tilt.from, tilt.from});
  CHECK(floor);
  CHECK(n.time_of_impact(rod, quarter, rod, Motion{})->t == 0);
  CHECK_THROWS_AS(n.time_of_impact(plate, Motion{}, plate, Motion{}), std::invalid_argument);
}

TEST_CASE("first touch on motions: apart before it, touching at it, never after a sampled touch, for all kinds") {
  Random r(17);
  const NarrowPhase n;
  int hits = 0, free = 0;
  for (std::size_t ia = 0; ia < shape_kinds; ++ia)
    for (std::size_t ib = 0; ib < shape_kinds; ++ib)
      for (int i = 0; i < 6; ++i) {
        const Shape a = random_shape(static_cast<ShapeKind>(ia), r), b = random_shape(static_cast<ShapeKind>(ib), r);
        if (!n.refuses(a, b, Request::distance).empty()) continue;
        const Motion ma{random_pose(r, 1), random_pose(r, 1)}, mb{random_pose(r, 4), random_pose(r, 4)};
        CAPTURE(name(a.kind()), name(b.kind()), i);
        const auto touch = n.time_of_impact(a, ma, b, mb);
        const auto distance_at = [&](double t) {
          return n.solve(a, pose_at(ma, t), b, pose_at(mb, t), Request::distance).signed_distance;
        };
        touch ? ++hits : ++free;
        const double end = touch ? touch->t : 1;
        for (int k = 0; k <= 100; ++k)
          if (end * k / 100 < end) CHECK(distance_at(end * k / 100) > 0);
        if (!touch) continue;
        CHECK(distance_at(touch->t) < 1e-8);
        if (touch->t > 0) CHECK(distance_at(touch->t) > -1e-8);
        // Swapped, the same time.
        const auto swapped = n.time_of_impact(b, mb, a, ma);
        REQUIRE(swapped);
        CHECK(std::abs(swapped->t - touch->t) < 1e-8);
      }
  CHECK(hits > 100);
  CHECK(free > 50);
}

TEST_CASE("first touch on motions: a mesh's triangle is named") {
  const NarrowPhase n;
  const Shape ring(torus(2, 0.5, 24, 12));
  const Pose still;
  const auto touch =
      n.time_of_impact(Sphere{0}, Motion{Pose::at(0, 0, 3), Pose::at(4, 0, -3)}, ring, Motion{still, still});
  REQUIRE(touch);
  REQUIRE(touch->feature[1] < ring.triangles().size());
  const auto corners = ring.triangles()[touch->feature[1]];
  const std::array<Vec3, 3> vertices{ring.vertices()[corners[0]], ring.vertices()[corners[1]],
                                     ring.vertices()[corners[2]]};
  CHECK(n.solve(Sphere{0}, pose_at({Pose::at(0, 0, 3), Pose::at(4, 0, -3)}, touch->t), Triangle{vertices}, still,
                Request::distance)
            .signed_distance < 1e-8);
}

TEST_CASE("first touch on motions: faces that turn in their plane beside another, a billionth apart, do not touch") {
  const NarrowPhase n;
  const Shape cube = Box{{1, 1, 1}}, floor = HalfSpace{Vec3::UnitZ(), 0.5}, mesh(box_mesh({1, 1, 1}, 2));
  for (const double gap : {1e-9, 1e-8, 1e-7})
    for (const Shape& other : {cube, floor, mesh}) {
      CAPTURE(gap, name(other.kind()));
      const auto turned = [&](double angle, double x) {
        return Pose{Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix(), Vec3(x, 0.1, 1 + gap)};
      };
      CHECK_FALSE(n.time_of_impact(cube, {turned(0, 0), turned(3, 0.3)}, other, Motion{}));
      CHECK_FALSE(n.time_of_impact(mesh, {turned(0, 0), turned(3, 0.3)}, other, Motion{}));
      // Both turn, the floor too.
      const Motion back{Pose{}, Pose{Eigen::AngleAxisd(-2, Vec3::UnitZ()).toRotationMatrix(), Vec3::Zero()}};
      CHECK_FALSE(n.time_of_impact(cube, {turned(0, 0), turned(3, 0.3)}, other, back));
    }
}

TEST_CASE("first touch on motions: a wheel that rolls a billionth above a floor does not touch it, a lower one does") {
  const NarrowPhase n;
  const Shape wheels[] = {Cylinder{0.5, 0.2}, Capsule{0.5, 0.2}, Ellipsoid{{0.5, 0.5, 0.1}},
                          Ellipsoid{{0.1, 0.5, 0.5}}};
  for (const Shape& wheel : wheels) {
    const bool about_x = wheel.kind() == ShapeKind::ellipsoid && wheel.radii().x() < 0.2;
    const Mat3 upright = about_x ? Eigen::AngleAxisd(std::acos(0.0), Vec3::UnitZ()).toRotationMatrix()
                                 : Eigen::AngleAxisd(std::acos(0.0), Vec3::UnitX()).toRotationMatrix();
    const auto rolled = [&](double angle, double height) {
      return Pose{Eigen::AngleAxisd(angle, Vec3::UnitY()).toRotationMatrix() * upright, Vec3(angle * 0.5, 0, height)};
    };
    for (const Shape& floor : {Shape(HalfSpace{}), Shape(Box{{20, 20, 1e-3}})}) {
      CAPTURE(name(wheel.kind()), name(floor.kind()));
      const double top = floor.kind() == ShapeKind::box ? 0.0005 : 0;
      for (const double gap : {1e-9, 1e-8, 1e-7}) {
        const double height = 0.5 + top + gap;
        CHECK_FALSE(n.time_of_impact(wheel, {rolled(0, height), rolled(3, height), Vec3::Zero()}, floor, Motion{}));
      }
      // It comes down by 0.3 while it rolls, and touches after a third.
      const auto touch =
          n.time_of_impact(wheel, {rolled(0, 0.6 + top), rolled(3, 0.3 + top), Vec3::Zero()}, floor, Motion{});
      REQUIRE(touch);
      CHECK(std::abs(touch->t - 1.0 / 3) < 1e-8);
    }
  }
}

TEST_CASE("motions whose numbers no time of impact can use are refused by name") {
  const auto refusal = [](const Motion& motion) {
    try {
      require_valid(motion, "motion");
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const Pose nowhere{Mat3::Identity(), {std::nan(""), 0, 0}};
  CHECK(refusal({}).empty());
  CHECK(refusal({{}, {}, Vec3(1, 2, 1e30)}).empty());
  CHECK(refusal({nowhere, {}}).starts_with("motion: from: translation[0] is nan"));
  CHECK(refusal({{}, nowhere}).starts_with("motion: to: translation[0] is nan"));
  CHECK(refusal({{}, {}, Vec3(0, 0, std::nan(""))}).starts_with("motion: straight_of[2] is nan"));
  CHECK(refusal({{}, {}, Vec3(0, -2e30, 0)}).starts_with("motion: straight_of[1] is -2"));
}
