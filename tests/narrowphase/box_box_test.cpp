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

namespace {

/// Two boxes that overlap or miss each other by little, as they do in a pile.
struct CloseBoxes {
  Shape a, b;
  Pose pose_a, pose_b;
};
CloseBoxes close_boxes(Random& r, double least, double most) {
  const auto size = [&r] { return Vec3(std::pow(10.0, r.in(-1, 0.5)), std::pow(10.0, r.in(-1, 0.5)), r.in(0.2, 2)); };
  CloseBoxes c{Box{size()}, Box{size()}, {r.rotation(), r.vec(-5, 5)}, {r.rotation(), Vec3::Zero()}};
  const Vec3 way = r.direction();
  const auto gap = [&](double far) {
    c.pose_b.translation = c.pose_a.translation + far * way;
    return NarrowPhase().solve(c.a, c.pose_a, c.b, c.pose_b, Request::distance).signed_distance;
  };
  const double wanted = r.in(least, most);
  double near = 0, far = 10;
  for (int i = 0; i < 60; ++i) (gap(0.5 * (near + far)) < wanted ? near : far) = 0.5 * (near + far);
  gap(near);
  return c;
}

}  // namespace

TEST_CASE("boxes told apart several at a time are those that the solver finds apart") {
  Random r(77);
  std::vector<CloseBoxes> boxes;
  for (int i = 0; i < 1500; ++i) {
    const double reach = std::pow(10.0, r.in(-13, 0));
    boxes.push_back(close_boxes(r, -reach, reach));
  }
  const Shape ball(Sphere{0.5});
  for (const double margin : {0.0, 1e-9, 0.01}) {
    const NarrowPhase n({.margin = margin});
    std::vector<PlacedPair> pairs;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const CloseBoxes& c = boxes[i];
      pairs.push_back({i % 7 == 3 ? &ball : &c.a, &c.pose_a, &c.b, &c.pose_b});
    }
    std::vector<std::uint8_t> apart(pairs.size(), 2);
    n.mark_apart(pairs, apart);
    int clear = 0, told = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      CAPTURE(margin, i);
      if (pairs[i].a == &ball) {
        CHECK(apart[i] == 0);
        continue;
      }
      const auto answer = n.solve(*pairs[i].a, *pairs[i].pose_a, *pairs[i].b, *pairs[i].pose_b, Request::distance);
      if (answer.signed_distance <= margin) CHECK(apart[i] == 0);
      // By an axis that separates by a fraction of the distance; one in a hundred may be left to the solver.
      if (answer.signed_distance > 4 * margin + 1e-9) ++clear, told += apart[i];
      std::uint8_t alone = 2;
      n.mark_apart({&pairs[i], 1}, {&alone, 1});
      CHECK(alone == apart[i]);
    }
    CHECK(clear > 100);
    CHECK((told == 0 || told > 0.9 * clear));  // 0: a machine without such lanes
  }
}

TEST_CASE("box-box: one contact point alone is given where one corner alone has gone in") {
  Random r(78);
  const NarrowPhase n;
  int lone = 0;
  for (int i = 0; i < 4000; ++i) {
    const CloseBoxes c = close_boxes(r, -0.05, -1e-4);
    std::vector<Contact> contacts;
    const auto answer = n.solve(c.a, c.pose_a, c.b, c.pose_b, Request::contacts, &contacts);
    REQUIRE(!contacts.empty());
    if (contacts.size() > 1) continue;
    CHECK(std::abs(contacts[0].depth + answer.signed_distance) < 1e-12);
    // Along a face's normal, the points of the edges within the other box.
    const Vec3 in_a = c.pose_a.rotation.transpose() * answer.normal,
               in_b = c.pose_b.rotation.transpose() * answer.normal;
    const bool of_a = in_a.cwiseAbs().maxCoeff() > 1 - 1e-12, of_b = in_b.cwiseAbs().maxCoeff() > 1 - 1e-12;
    if (of_a == of_b) continue;
    ++lone;
    const Shape &reference = of_a ? c.a : c.b, &incident = of_a ? c.b : c.a;
    const Pose &pose = of_a ? c.pose_a : c.pose_b, &other = of_a ? c.pose_b : c.pose_a;
    const auto inside = [](const Shape& box, const Pose& at, const Vec3& p) {
      return ((at.rotation.transpose() * (p - at.translation)).cwiseAbs().array() < box.half_size().array() - 1e-7)
          .all();
    };
    const auto edge_point = [](const Shape& box, const Pose& at, int edge, double s) {
      const int k = edge / 4;
      Vec3 p = box.half_size();
      p[k] *= s;
      if (edge % 2 != 0) p[(k + 1) % 3] *= -1;
      if (edge / 2 % 2 != 0) p[(k + 2) % 3] *= -1;
      return Vec3(at * p);
    };
    int corners = 0;
    for (int edge = 0; edge < 12; ++edge)
      for (int s = -20; s <= 20; ++s) {
        CHECK(!inside(incident, other, edge_point(reference, pose, edge, 0.05 * s)));
        const bool in = inside(reference, pose, edge_point(incident, other, edge, 0.05 * s));
        if (in && std::abs(s) == 20) ++corners;
        if (!in) continue;
        // On an edge that ends in the corner that has gone in.
        const bool plus = inside(reference, pose, edge_point(incident, other, edge, 1)),
                   minus = inside(reference, pose, edge_point(incident, other, edge, -1));
        CHECK((plus || minus));
      }
    CHECK(corners <= 3);  // one corner, of three edges
  }
  CHECK(lone > 300);
}
