#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "random_pairs.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("box-box: two edges that cross touch in one point, with the depth between the edges") {
  // Each cube stands on an edge; the two edges cross at a right angle and overlap by 0.02.
  const Mat3 ra = Eigen::AngleAxisd(0.25 * M_PI, Vec3::UnitX()).toRotationMatrix();
  const Mat3 rb = Eigen::AngleAxisd(0.25 * M_PI, Vec3::UnitY()).toRotationMatrix();
  const Shape box(Box{{1, 1, 1}});
  const NarrowPhase n;
  const double reach = std::sqrt(0.5);
  std::vector<Contact> contacts;
  const auto answer =
      n.solve(box, {ra, Vec3::Zero()}, box, {rb, Vec3(0, 0, 2 * reach - 0.02)}, Request::contacts, &contacts);
  CHECK(std::abs(answer.signed_distance + 0.02) < 1e-14);
  CHECK(answer.normal.isApprox(Vec3::UnitZ(), 1e-12));
  REQUIRE(contacts.size() == 1);
  CHECK(contacts[0].point.isApprox(Vec3(0, 0, reach - 0.01), 1e-12));
}

TEST_CASE("box-box: stacked boxes touch in the four corners of the overlap") {
  const NarrowPhase n;
  const Shape big(Box{{4, 4, 1}}), small(Box{{1, 2, 1}});
  for (const double yaw : {0.0, 0.3, 1e-9, 0.5 * M_PI})
    for (const double tilt : {0.0, 1e-9, -1e-6}) {
      const Mat3 r =
          (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(tilt, Vec3::UnitX())).toRotationMatrix();
      std::vector<Contact> contacts;
      const auto answer = n.solve(big, Pose{}, small, {r, Vec3(0.2, -0.3, 0.99)}, Request::contacts, &contacts);
      CAPTURE(yaw, tilt);
      CHECK(std::abs(answer.signed_distance + 0.01) < 2e-6);
      REQUIRE(contacts.size() == 4);
      for (const Contact& c : contacts) {
        CHECK(std::abs(c.depth - 0.01) < 2e-6);
        const Vec3 local = r.transpose() * (c.point - Vec3(0.2, -0.3, 0.99));
        CHECK(std::abs(std::abs(local.x()) - 0.5) < 1e-6);
        CHECK(std::abs(std::abs(local.y()) - 1.0) < 1e-6);
      }
      CHECK(std::is_sorted(contacts.begin(), contacts.end(),
                           [](const Contact& x, const Contact& y) { return x.feature < y.feature; }));
    }
}

TEST_CASE("box-box: nearly parallel edges never make depth of nothing") {
  Random r(21);
  const NarrowPhase n;
  const Shape box(Box{{1, 1, 1}});
  for (int i = 0; i < 2000; ++i) {
    const double angle = std::pow(10.0, r.in(-17, -1));
    const Mat3 turn = Eigen::AngleAxisd(angle, r.direction()).toRotationMatrix();
    const Vec3 t = r.vec(-0.3, 0.3);
    const auto answer = n.solve(box, Pose{}, box, {turn, t}, Request::distance);
    // Parallel boxes overlap by 1 - max |t|; turning by `angle` changes it by no more than about 2 angles.
    CAPTURE(angle, t.transpose());
    CHECK(std::abs(-answer.signed_distance - (1 - t.cwiseAbs().maxCoeff())) < 2 * angle + 1e-14);
    CHECK(n.solve(box, Pose{}, box, {turn, t}, Request::collide).collide);
  }
}

TEST_CASE("box-box: a cube on a cube changes its verdict where it touches, far from the origin too") {
  const NarrowPhase n;
  const Shape box(Box{{1, 1, 1}});
  for (const double far : {0.0, 1e3, 1e6}) {
    const double ulp = 0x1p-30;
    CHECK(n.solve(box, Pose::at(far, far, far), box, Pose::at(far + 1, far, far), Request::collide).collide);
    CHECK_FALSE(
        n.solve(box, Pose::at(far, far, far), box, Pose::at(far + 1 + ulp, far, far), Request::collide).collide);
    CHECK(n.solve(box, Pose::at(far, far, far), box, Pose::at(far + 1 + ulp, far, far), Request::distance)
              .signed_distance == ulp);
  }
}
