// Boxes of links in many configurations, and gaps between them under rotations, compared with bounds and distances.
#include "queries/link_boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.h"
#include "narrowphase/random_pairs.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using namespace tandem::test;

namespace {

struct Links {
  std::vector<Shape> shapes;
  std::vector<LinkBox> boxes;

  explicit Links(Random& random) {
    for (std::size_t kind = 0; kind < shape_kinds; ++kind)
      if (static_cast<ShapeKind>(kind) != ShapeKind::halfspace) add(random_shape(static_cast<ShapeKind>(kind), random));
    add(Shape(Box{{0.4, 0.3, 0.8}}).rounded(0.1));
  }
  void add(const Shape& shape) {
    if (!shape.is_bounded()) return;
    shapes.push_back(shape);
    boxes.emplace_back(shape);
  }
};

}  // namespace

TEST_CASE("link boxes: hold the links, hardly larger than needed, for any number of configurations") {
  Random random(31);
  const Links links(random);
  const std::size_t n = links.shapes.size();
  for (const std::size_t count : {1u, 3u, 16u, 64u, 65u, 150u})
    for (const double far : {1.0, 1e4}) {
      std::vector<Pose> poses;
      for (std::size_t i = 0; i < (count + 2) * n; ++i) poses.push_back(random_pose(random, far));
      LinkBoxes boxes;
      REQUIRE(boxes.take(links.boxes, poses, 2, count, {}));
      for (std::size_t link = 0; link < n; ++link)
        for (std::size_t k = 0; k < count; ++k) {
          CAPTURE(count, far, k, name(links.shapes[link].kind()));
          const Pose& pose = poses[(2 + k) * n + link];
          const LinkBox& own = links.boxes[link];
          const Bounds bounds = links.shapes[link].bounds(pose);
          const Vec3 middle = pose * own.centre,
                     half = pose.rotation.cwiseAbs() * own.half + Vec3::Constant(own.radius);
          const Aabb box = boxes.box(link, k);
          for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto row = static_cast<Eigen::Index>(axis);
            REQUIRE(double{box.lo[axis]} <= bounds.lo[row]);
            REQUIRE(double{box.hi[axis]} >= bounds.hi[row]);
            const double more = 3e-6 * (std::abs(pose.translation[row]) + own.reach());
            REQUIRE(double{box.lo[axis]} >= middle[row] - half[row] - more);
            REQUIRE(double{box.hi[axis]} <= middle[row] + half[row] + more);
            REQUIRE(boxes.swept(link).lo[axis] <= box.lo[axis]);
            REQUIRE(boxes.swept(link).hi[axis] >= box.hi[axis]);
          }
        }
    }
}

TEST_CASE("link boxes: a gap is never more than the distance, and all of it along faces") {
  Random random(32);
  const Links links(random);
  const std::size_t n = links.shapes.size(), count = 70;
  const NarrowPhase narrow;
  std::size_t apart = 0, meeting = 0;
  for (int round = 0; round < 8; ++round) {
    std::vector<Pose> poses;
    for (std::size_t i = 0; i < count * n; ++i) poses.push_back(random_pose(random, 2));
    LinkBoxes boxes;
    REQUIRE(boxes.take(links.boxes, poses, 0, count, {}));
    const std::size_t a = static_cast<std::size_t>(round) % n, b = (a + 1 + static_cast<std::size_t>(round) / 2) % n;
    const Pose body_pose = random_pose(random, 1);
    const Bounds bounds = links.shapes[b].bounds(body_pose);
    Aabb world{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      world.lo[axis] = round_down(bounds.lo[static_cast<Eigen::Index>(axis)]);
      world.hi[axis] = round_up(bounds.hi[static_cast<Eigen::Index>(axis)]);
    }
    const PlacedBox body(links.boxes[b], body_pose, world);
    for (std::size_t k = 0; k < count; ++k) {
      const Pose &at = poses[k * n + a], &other = poses[k * n + b];
      CAPTURE(round, k, name(links.shapes[a].kind()), name(links.shapes[b].kind()));
      const auto distance = [&](const Pose& pose) {
        return narrow.solve(links.shapes[a], at, links.shapes[b], pose, Request::distance).signed_distance;
      };
      const double gap = boxes.gap(k, a, {links.boxes[b], other, boxes.box(b, k)}), body_gap = boxes.gap(k, a, body);
      if (gap > 0) REQUIRE(gap <= distance(other));
      if (body_gap > 0) REQUIRE(body_gap <= distance(body_pose));
      const bool is_apart = known_apart(links.boxes[a], at, links.boxes[b], body_pose);
      if (is_apart) REQUIRE(distance(body_pose) > 0);
      if (std::abs(body_gap) > 0.001) REQUIRE(is_apart == (body_gap > 0));  // both look along the same axes
      const auto bit = [&](std::uint64_t bits) { return (bits >> k % 64 & 1) != 0; };
      REQUIRE(bit(boxes.meeting(k / 64, a, b)) == (overlap(boxes.box(a, k), boxes.box(b, k)) && gap <= 0));
      REQUIRE(bit(boxes.meeting(k / 64, a, body)) == (overlap(boxes.box(a, k), world) && body_gap <= 0));
      apart += overlap(boxes.box(a, k), boxes.box(b, k)) && gap > 0;
      meeting += bit(boxes.meeting(k / 64, a, b));
    }
    CHECK(boxes.meeting(1, a, body) >> (count - 64) == 0);
  }
  CHECK(apart > 10);
  CHECK(meeting > 10);

  // Two boxes and a capsule side by side, rotated together.
  const std::vector<Shape> shapes{Shape(Box{{1, 1, 1}}), Shape(Capsule{0.2, 1}), Shape(Box{{0.4, 0.3, 0.8}})};
  std::vector<LinkBox> own;
  for (const Shape& shape : shapes) own.emplace_back(shape);
  const Pose turn = random_pose(random, 1);
  const auto turned = [&](const Vec3& place) { return Pose{turn.rotation, turn * place}; };
  const std::vector<Pose> poses{turn, turned({1.5, 0, 0}), turned({0.1, 0.95, 0.2})};
  LinkBoxes boxes;
  REQUIRE(boxes.take(own, poses, 0, 1, {}));
  const auto gap = [&](std::size_t link, std::size_t other) {
    return boxes.gap(0, link, {own[other], poses[other], boxes.box(other, 0)});
  };
  CHECK(gap(0, 1) == Approx(0.8).margin(2e-4));
  CHECK(gap(1, 0) == Approx(0.8).margin(2e-4));
  CHECK(gap(0, 2) == Approx(0.3).margin(2e-4));
}

TEST_CASE("link boxes: poses that are none are told") {
  Random random(33);
  const std::vector<LinkBox> links{LinkBox(Shape(Sphere{0.1})), LinkBox(Shape(Box{{1, 2, 3}}))};
  std::vector<Pose> poses;
  for (int i = 0; i < 200; ++i) poses.push_back(random_pose(random, 3));
  LinkBoxes boxes;
  const auto taken = [&] { return boxes.take(links, poses, 0, 100, {}); };
  for (const std::size_t at : {0u, 1u, 77u, 199u}) {
    const Pose good = poses[at];
    for (int k = 0; k < 12; ++k) {
      (k < 9 ? poses[at].rotation.data()[k] : poses[at].translation.data()[k - 9]) =
          std::numeric_limits<double>::quiet_NaN();
      CHECK_FALSE(taken());
      poses[at] = good;
    }
    poses[at].rotation *= 1 + 2e-6;
    CHECK_FALSE(taken());
    poses[at].rotation = -good.rotation;
    CHECK_FALSE(taken());
    poses[at] = good;
    poses[at].translation.y() = -2e30;
    CHECK_FALSE(taken());
    poses[at] = good;
    poses[at].rotation *= 1 + 1e-7;
    CHECK(taken());
    poses[at] = good;
    CHECK(taken());
  }
}
