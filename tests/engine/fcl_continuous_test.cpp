// tandem::fcl::continuousCollide compared with samples of FCL's motions, and with FCL's own answers.
#include "tandem/fcl/continuous_queries.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/geometric_shape_to_BVH_model.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cone.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/geometry/shape/halfspace.h>
#include <fcl/geometry/shape/plane.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/continuous_collision.h>

#include <cmath>
#include <limits>
#include <random>

#include "catch.h"
#include "message_of.h"

namespace {

using MovedGeometry = std::shared_ptr<::fcl::CollisionGeometryd>;
using Transform = ::fcl::Transform3d;
using Request = ::fcl::ContinuousCollisionRequestd;
using Result = ::fcl::ContinuousCollisionResultd;

Request request_of(::fcl::CCDMotionType type) {
  Request request;
  request.ccd_motion_type = type;
  return request;
}

std::vector<MovedGeometry> kinds() {
  auto mesh = std::make_shared<::fcl::BVHModel<::fcl::OBBRSSd>>();
  ::fcl::generateBVHModel(*mesh, ::fcl::Boxd(0.8, 0.5, 0.6), Transform::Identity());
  return {std::make_shared<::fcl::Sphered>(0.4),
          std::make_shared<::fcl::Boxd>(0.5, 0.8, 0.4),
          std::make_shared<::fcl::Capsuled>(0.2, 0.7),
          std::make_shared<::fcl::Cylinderd>(0.3, 0.6),
          std::make_shared<::fcl::Coned>(0.4, 0.7),
          mesh,
          std::make_shared<::fcl::Halfspaced>(::fcl::Vector3d(0, 0, 1), -1.5)};
}

Transform moved(const Transform& from, std::mt19937& random, double turn, double shift) {
  std::uniform_real_distribution<double> number(-1, 1);
  Transform to = from;
  const ::fcl::Vector3d axis{number(random), number(random), number(random)};
  to.linear() = Eigen::AngleAxisd(turn * number(random), axis.normalized()).toRotationMatrix() * from.linear();
  to.translation() += shift * ::fcl::Vector3d{number(random), number(random), number(random)};
  return to;
}

Transform at(::fcl::CCDMotionType type, const Transform& from, const Transform& to, double t) {
  Transform now;
  const auto run = [&](const ::fcl::MotionBased& motion) { motion.integrate(t), motion.getCurrentTransform(now); };
  if (type == ::fcl::CCDM_TRANS)
    run(::fcl::TranslationMotiond(from, to));
  else if (type == ::fcl::CCDM_LINEAR)
    run(::fcl::InterpMotion<double>(from.linear(), from.translation(), to.linear(), to.translation(),
                                    ::fcl::Vector3d::Zero()));
  else
    run(::fcl::ScrewMotion<double>(from, to));
  return now;
}

double distance(const MovedGeometry& a, const Transform& pose_a, const MovedGeometry& b, const Transform& pose_b) {
  ::fcl::DistanceRequestd request;
  ::fcl::DistanceResultd result;
  request.enable_signed_distance = true;
  return tandem::fcl::distance(a.get(), pose_a, b.get(), pose_b, request, result);
}

}  // namespace

TEST_CASE("FCL's continuous collision: the first touch on FCL's motions, none missed and none late") {
  std::mt19937 random(71);
  const std::vector<MovedGeometry> all = kinds();
  std::size_t touches = 0, free = 0, at_start = 0;
  for (const auto type : {::fcl::CCDM_TRANS, ::fcl::CCDM_LINEAR, ::fcl::CCDM_SCREW})
    for (std::size_t i = 0; i < all.size(); ++i)
      for (std::size_t j = 0; j < all.size(); ++j) {
        if (i + 1 == all.size() && i == j) continue;
        const Transform from1 = moved(Transform::Identity(), random, 3, 1.6), to1 = moved(from1, random, 2, 3);
        const Transform from2 = moved(Transform::Identity(), random, 3, 1.6), to2 = moved(from2, random, 2, 3);
        const ::fcl::CollisionObjectd o1(all[i], from1), o2(all[j], from2);
        Result result;
        const double t = tandem::fcl::continuousCollide(&o1, to1, &o2, to2, request_of(type), result);
        CAPTURE(type, i, j, t);
        REQUIRE(t == result.time_of_contact);
        Result again;
        REQUIRE(tandem::fcl::continuousCollide(all[i].get(), from1, to1, all[j].get(), from2, to2, request_of(type),
                                               again) == t);
        const auto gap = [&](double time) {
          return distance(all[i], at(type, from1, to1, time), all[j], at(type, from2, to2, time));
        };
        for (int k = 0; k <= 60; ++k) {
          const double time = k / 60.0;
          if (time < t - 1e-9) REQUIRE(gap(time) > 0);
          if (!result.is_collide) REQUIRE(gap(time) > 0);
        }
        CHECK((result.contact_tf1.matrix() - at(type, from1, to1, t).matrix()).norm() < 1e-9);
        CHECK((result.contact_tf2.matrix() - at(type, from2, to2, t).matrix()).norm() < 1e-9);
        if (result.is_collide && t > 0)
          CHECK(std::abs(distance(all[i], result.contact_tf1, all[j], result.contact_tf2)) < 1e-8);
        if (t == 0) CHECK(gap(0) <= 1e-9);
        touches += result.is_collide && t > 0;
        free += !result.is_collide;
        at_start += t == 0;
      }
  CHECK(touches > 10);
  CHECK(free > 20);
  CHECK(at_start > 5);
}

TEST_CASE("FCL's continuous collision: a thin wall, float, what is not occupied, planes and bad transforms") {
  const auto bullet = std::make_shared<::fcl::Sphered>(0.01);
  const auto wall = std::make_shared<::fcl::Boxd>(0.001, 2, 2);
  Transform start = Transform::Identity(), end = start;
  start.translation().x() = -1.1;
  end.translation().x() = 1.9;
  const Transform home = Transform::Identity();
  Result ours, theirs;
  CHECK(tandem::fcl::continuousCollide<double>(bullet.get(), start, end, wall.get(), home, home, Request(), ours) ==
        Approx((1.1 - 0.0105) / 3).epsilon(1e-9));
  CHECK(ours.is_collide);
  ::fcl::continuousCollide<double>(bullet.get(), start, end, wall.get(), home, home, Request(), theirs);
  CHECK_FALSE(theirs.is_collide);  // FCL examines ten times of the motion

  const ::fcl::Spheref small(0.01f);
  const ::fcl::Boxf thin(0.001f, 2, 2);
  ::fcl::ContinuousCollisionResultf in_float;
  const ::fcl::Transform3f start_f = start.cast<float>(), end_f = end.cast<float>(), home_f = home.cast<float>();
  CHECK(tandem::fcl::continuousCollide<float>(&small, start_f, end_f, &thin, home_f, home_f, {}, in_float) ==
        Approx((1.1 - 0.0105) / 3).epsilon(1e-5));
  const ::fcl::Planef plane_f(::fcl::Vector3f(1, 0, 0), 0);
  CHECK(tandem::fcl::continuousCollide<float>(&small, start_f, end_f, &plane_f, home_f, home_f, {}, in_float) ==
        Approx((1.1 - 0.01) / 3).epsilon(1e-5));
  ::fcl::ContinuousCollisionRequestf along_spline;
  along_spline.ccd_motion_type = ::fcl::CCDM_SPLINE;
  CHECK(tandem::message_of([&] {
          tandem::fcl::continuousCollide<float>(&small, start_f, end_f, &thin, home_f, home_f, along_spline, in_float);
        }).find("float") != std::string::npos);

  const auto off = [&] {
    tandem::fcl::continuousCollide<double>(bullet.get(), start, end, wall.get(), home, home, Request(), ours);
    return ours.is_collide;
  };
  wall->threshold_occupied = 2;  // of a cost density of 1
  CHECK_FALSE(off());
  CHECK(ours.time_of_contact == 1);
  CHECK((ours.contact_tf1.translation() - end.translation()).norm() == 0);

  const ::fcl::Planed plane(::fcl::Vector3d(1, 0, 0), 0);
  for (const bool from_behind : {false, true})
    CHECK(tandem::fcl::continuousCollide<double>(bullet.get(), from_behind ? end : start, from_behind ? start : end,
                                                 &plane, home, home, Request(), ours) ==
          Approx((from_behind ? 1.9 - 0.01 : 1.1 - 0.01) / 3).epsilon(1e-9));

  Transform bad = end;
  bad.translation().y() = std::numeric_limits<double>::quiet_NaN();
  CHECK(tandem::message_of([&] {
          tandem::fcl::continuousCollide<double>(bullet.get(), start, bad, wall.get(), home, home, Request(), ours);
        }).find("translation[1]") != std::string::npos);
}
