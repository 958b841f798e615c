// Contact manifolds: exchanging the bodies or tiny motions must not change them.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "catch.h"
#include "manifold/feature_overlap.h"
#include "manifold/patch_collector.h"
#include "mesh_samples.h"
#include "random_pairs.h"

using namespace tandem;
using namespace tandem::test;

namespace {

std::vector<Contact> contacts_of(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb) {
  std::vector<Contact> contacts;
  NarrowPhase().solve(a, pa, b, pb, Request::contacts, &contacts);
  return contacts;
}

Pose nudged(const Pose& pose, Random& r) {
  const Mat3 turn = Eigen::AngleAxisd(1e-9, r.direction()).toRotationMatrix();
  return {pose.rotation * turn, pose.translation + 1e-9 * r.direction()};
}

/// The corners of a square about a point, by decreasing depth.
std::vector<Contact> square(const Vec3& at, const Vec3& normal, double depth) {
  std::vector<Contact> corners;
  for (const auto& [x, y] : {std::pair(1, 1), std::pair(-1, 1), std::pair(-1, -1), std::pair(1, -1)})
    corners.push_back({at + Vec3(x, y, 0), normal, depth -= 0.01, 77});
  return corners;
}

/// A box on a box, overlapping by 0.01: aligned with it, or rotated about the vertical with its corners over the
/// other's.
struct Stack {
  Shape below, above;
  Pose pose_below, pose_above;
};

Stack stack(double yaw, const Vec3& size, const Vec3& offset, const Pose& frame) {
  const Pose local{Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix(),
                   offset + Vec3(0, 0, 0.5 + 0.5 * size.z() - 0.01)};
  return {Shape(Box{{1, 1, 1}}), Shape(Box{size}), frame, {frame.rotation * local.rotation, frame * local.translation}};
}

}  // namespace

TEST_CASE("manifold: exchanging two boxes or two capsules gives the same contacts, bit for bit") {
  Random r(71);
  int touching = 0;
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::box, ShapeKind::capsule})
    for (int i = 0; i < 1000; ++i) {
      const Shape a = random_shape(kind, r), b = i % 3 == 0 ? a : random_shape(kind, r);
      const Pose pa = random_pose(r, 0.4);
      Pose pb = random_pose(r, 0.4);
      if (i % 2 == 0) pb.rotation = pa.rotation;
      CAPTURE(name(kind), i);
      const std::vector<Contact> one = contacts_of(a, pa, b, pb), other = contacts_of(b, pb, a, pa);
      REQUIRE(one.size() == other.size());
      for (std::size_t k = 0; k < one.size(); ++k) {
        CHECK(one[k].point == other[k].point);
        CHECK(one[k].normal == -other[k].normal);
        CHECK(one[k].depth == other[k].depth);
        CHECK(one[k].feature == other[k].feature);
      }
      touching += one.empty() ? 0 : 1;
      CHECK(NarrowPhase().solve(a, pa, b, pb, Request::collide).collide == !one.empty());
    }
  CHECK(touching > 1000);
}

TEST_CASE("manifold: boxes stacked keep their points, names and order when moved by 1e-9") {
  Random r(72);
  for (const double yaw : {0.0, 0.25 * M_PI, 0.5 * M_PI, 0.3})
    for (const Vec3& size : {Vec3(1, 1, 1), Vec3(0.5, 0.7, 1), Vec3(3, 0.2, 0.4)})
      for (const Vec3& offset : {Vec3(0, 0, 0), Vec3(0.5, 0.5, 0), Vec3(0.1, -0.2, 0)}) {
        const Stack s = stack(yaw, size, offset, random_pose(r, 2));
        const std::vector<Contact> still = contacts_of(s.below, s.pose_below, s.above, s.pose_above);
        CAPTURE(yaw, size.transpose(), offset.transpose());
        REQUIRE(still.size() >= 3);
        REQUIRE(still.size() <= 4);
        for (int i = 0; i < 20; ++i) {
          const auto moved = contacts_of(s.below, nudged(s.pose_below, r), s.above, nudged(s.pose_above, r));
          REQUIRE(moved.size() == still.size());
          for (std::size_t k = 0; k < still.size(); ++k) {
            CHECK(moved[k].feature == still[k].feature);
            CHECK((moved[k].point - still[k].point).norm() < 1e-6);
            CHECK(std::abs(moved[k].depth - still[k].depth) < 1e-8);
          }
        }
      }
}

TEST_CASE("manifold: discs, prisms and boxes whose outlines lie on each other keep their points when moved by 1e-9") {
  Random r(74);
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k)
    for (const double z : {-0.5, 0.5}) corners.emplace_back(std::cos(k * M_PI / 4), std::sin(k * M_PI / 4), z);
  const std::vector<Shape> below{Shape(Cylinder{1, 1}), Shape(Convex{corners}), Shape(Box{{2, 2, 1}})};
  std::vector<Shape> above = below;
  above.emplace_back(Cone{1, 1});
  above.emplace_back(Cylinder{0.5, 1});
  for (const Shape& a : below)
    for (const Shape& b : above)
      for (const Vec3& offset : {Vec3(0, 0, 0.99), Vec3(0.5, 0, 0.99), Vec3(0.3, 0.1, 0.99)})
        for (const double yaw : {0.0, 0.25 * M_PI}) {
          const Pose frame = random_pose(r, 2);
          const Pose pb{frame.rotation * Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix(), frame * offset};
          const std::vector<Contact> still = contacts_of(a, frame, b, pb);
          CAPTURE(name(a.kind()), name(b.kind()), offset.transpose(), yaw);
          REQUIRE(still.size() >= 3);
          REQUIRE(still.size() <= 4);
          for (int i = 0; i < 10; ++i) {
            const auto moved = contacts_of(a, nudged(frame, r), b, nudged(pb, r));
            REQUIRE(moved.size() == still.size());
            for (std::size_t k = 0; k < still.size(); ++k) {
              CHECK(moved[k].feature == still[k].feature);
              CHECK((moved[k].point - still[k].point).norm() < 1e-6);
            }
          }
        }
}

TEST_CASE("manifold: a disc that leans a little spans its face, and its points stay when it is moved by 1e-9") {
  Random r(75);
  const std::vector<Shape> below{Shape(Box{{4, 4, 1}}), Shape(HalfSpace{{0, 0, 1}, 0.5}), Shape(Cylinder{2, 1}),
                                 Shape(Convex{{{-3, -3, 0.5}, {3, -3, 0.5}, {0, 4, 0.5}, {0, 0, -2}}})};
  const std::vector<Shape> above{Shape(Cylinder{0.5, 1}), Shape(Cone{0.5, 1})};
  int asked = 0, moved = 0;
  for (const Shape& a : below)
    for (const Shape& b : above)
      for (const double lean : {1e-8, 3e-8, 1e-7, 1e-6, 1e-5, 1e-4, 9e-4})
        for (int i = 0; i < 10; ++i) {
          const Pose frame = random_pose(r, 2);
          const double angle = r.in(0, 2 * M_PI);
          const Mat3 turn = (Eigen::AngleAxisd(lean, Vec3(std::cos(angle), std::sin(angle), 0)) *
                             Eigen::AngleAxisd(r.in(0, 6), Vec3::UnitZ()))
                                .toRotationMatrix();
          const Pose pb{frame.rotation * turn, frame * Vec3(0.1, -0.2, 0.999)};
          NarrowPhaseOptions options;
          options.margin = 0.01;
          NarrowPhase solver(options);
          const auto ask = [&](const Pose& at) {
            std::vector<Contact> contacts;
            const auto answer = solver.solve(a, frame, b, at, Request::contacts, &contacts);
            REQUIRE(contacts.size() == 4);
            double deepest = -1;
            for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
            CHECK(std::abs(deepest + answer.signed_distance) < 1e-15);
            return contacts;
          };
          CAPTURE(name(a.kind()), name(b.kind()), lean, i);
          const std::vector<Contact> still = ask(pb);
          for (const Contact& c : still) {
            // The point is midway, so half a depth away is on either surface.
            const Vec3 in_above = pb.rotation.transpose() * (c.point - 0.5 * c.depth * c.normal - pb.translation);
            const Vec3 in_below = frame.rotation.transpose() * (c.point + 0.5 * c.depth * c.normal - frame.translation);
            CHECK(std::abs(in_above.z() + 0.5) < 1e-9);
            CHECK(std::abs(in_above.head<2>().norm() - 0.5) < 1e-8);
            CHECK(std::abs(in_below.z() - 0.5) < 1e-9);
          }
          // Twice the area of four corners of a disc, of which the deepest replaced the nearest.
          double area = 0;
          for (std::size_t k = 1; k < 4; ++k)
            for (std::size_t m = 1; m < 4; ++m)
              if (m != k) {
                const Vec3 one = still[k].point - still[0].point, other = still[6 - k - m].point - still[m].point;
                area = std::max(area, std::abs(still[0].normal.dot(one.cross(other))));
              }
          CHECK(area > 2 * 0.25 * 1.7);
          for (int j = 0; j < 5; ++j) {
            const std::vector<Contact> now = ask(nudged(pb, r));
            int left = 0;
            for (const Contact& c : still)
              left += std::none_of(now.begin(), now.end(), [&](const Contact& d) {
                return d.feature == c.feature && (d.point - c.point).norm() < 1e-6;
              });
            ++asked;
            moved += left > 0 ? 1 : 0;
            if (lean > 1e-7) CHECK(left <= 1);
          }
        }
  INFO(moved << " of " << asked);
  // About one in twenty, plus three standard deviations, since rounding changes the sample.
  CHECK(moved < asked / 20 + 35);
}

TEST_CASE("manifold: a disc is carried alike whichever way it leans") {
  const Shape disc(Cylinder{0.5, 1});
  for (const Shape& floor : {Shape(HalfSpace{{0, 0, 1}, 0.5}), Shape(Box{{4, 4, 1}})})
    for (const double lean : {1e-6, 1e-4, 1e-2})
      for (int i = 0; i < 100; ++i) {
        const double angle = 0.02 * M_PI * i;
        const Pose at{Eigen::AngleAxisd(lean, Vec3(std::cos(angle), std::sin(angle), 0)).toRotationMatrix(),
                      Vec3(0.1, -0.2, 0.98)};
        const std::vector<Contact> contacts = contacts_of(floor, Pose{}, disc, at);
        CAPTURE(name(floor.kind()), lean, angle);
        REQUIRE(contacts.size() == 4);
        // The stiffness against leaning of four equal springs at the points, by direction.
        Eigen::Vector2d middle = Eigen::Vector2d::Zero();
        for (const Contact& c : contacts) middle += 0.25 * c.point.head<2>();
        Eigen::Matrix2d stiffness = Eigen::Matrix2d::Zero();
        for (const Contact& c : contacts)
          stiffness += (c.point.head<2>() - middle) * (c.point.head<2>() - middle).transpose();
        const Eigen::Vector2d by_direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(stiffness).eigenvalues();
        CHECK(by_direction[1] < 1.25 * by_direction[0]);
      }
}

TEST_CASE("manifold: no point lies far beyond the tip of a needle, however large the other body is") {
  const Shape needle(Convex{{Vec3(0, -3, 0), Vec3(0, 3, 0), Vec3(-9000, 0, 0), Vec3(0, 0, -1)}});
  for (const double length : {1e4, 1e6, 1e9}) {
    std::vector<Vec3> corners;
    for (const double x : {-0.5 * length, 0.5 * length})
      for (const double y : {-0.5, 0.5})
        for (const double z : {-0.5, 0.5}) corners.emplace_back(x, y, z);
    const Shape beam(Convex{corners});
    for (const double lean : {0.0, 1e-12}) {
      const Pose at{Eigen::AngleAxisd(lean, Vec3::UnitY()).toRotationMatrix(), Vec3(0, 0, 0.49)};
      for (const bool swapped : {false, true}) {
        const auto contacts = swapped ? contacts_of(beam, at, needle, Pose()) : contacts_of(needle, Pose(), beam, at);
        CAPTURE(length, lean, swapped);
        REQUIRE(contacts.size() >= 2);
        for (const Contact& c : contacts) {
          CHECK(c.point.x() > -9000 - 1e-7 * length);
          CHECK(c.point.x() < 1e-7 * length);
        }
      }
    }
  }
}

TEST_CASE("manifold: the points of a stack span what the faces share") {
  Random r(73);
  for (int i = 0; i < 300; ++i) {
    const Vec3 size = r.vec(0.3, 1.5);
    const double angle = r.in(0, 6);
    const Vec3 shift{r.in(-0.4, 0.4), r.in(-0.4, 0.4), 0};
    const Stack s = stack(angle, size, shift, random_pose(r, 2));
    const auto contacts = contacts_of(s.below, s.pose_below, s.above, s.pose_above);
    CAPTURE(i);
    REQUIRE(contacts.size() >= 3);
    REQUIRE(contacts.size() <= 4);
    Vec3 lo = Vec3::Constant(1e300), hi = -lo;
    for (const Contact& c : contacts) {
      CHECK(std::abs(c.depth - 0.01) < 1e-12);
      const Vec3 in_below = s.pose_below.rotation.transpose() * (c.point - s.pose_below.translation);
      const Vec3 in_above = s.pose_above.rotation.transpose() * (c.point - s.pose_above.translation);
      CHECK(in_below.head<2>().cwiseAbs().maxCoeff() < 0.5 + 1e-7);
      CHECK((in_above.head<2>().cwiseAbs() - 0.5 * size.head<2>()).maxCoeff() < 1e-7);
      CHECK(std::abs(in_below.z() - 0.495) < 1e-12);
      lo = lo.cwiseMin(in_below);
      hi = hi.cwiseMax(in_below);
    }
    CHECK((hi - lo).head<2>().minCoeff() > 0.05);
  }
}

TEST_CASE("manifold: small boxes by the rim of a disc, or of a face of many corners, stand on all four of theirs") {
  Convex prism;
  for (const double z : {-0.5, 0.5})
    for (int i = 0; i < 64; ++i)
      prism.vertices.push_back({std::cos(i * std::numbers::pi / 32), std::sin(i * std::numbers::pi / 32), z});
  for (const Shape& table : {Shape(Cylinder{1, 1}), Shape(prism)})
    for (const double size : {0.1, 0.02, 0.01, 0.001, 1e-4})
      for (int i = 0; i < 48; ++i) {
        const Shape box(Box{Vec3::Constant(size)});
        const Mat3 turn = Eigen::AngleAxisd(0.1 + i * std::numbers::pi / 24, Vec3::UnitZ()).toRotationMatrix();
        // Its outer corners are a tenth of its size off the rim, which between 64 corners is 1.2e-3 farther in.
        const double reach = std::sqrt(1 - 0.25 * size * size) - 1.3e-3 - 0.6 * size;
        const Pose on_it{turn, turn * Vec3(reach, 0, 0.5 + 0.5 * size - 1e-3 * size)};
        CAPTURE(name(table.kind()), size, i);
        for (const bool exchanged : {false, true}) {
          const auto patch = exchanged ? contacts_of(box, on_it, table, {}) : contacts_of(table, {}, box, on_it);
          REQUIRE(patch.size() == 4);
          for (const Contact& c : patch) {
            const Vec3 p = turn.transpose() * (c.point - on_it.translation);
            CHECK(std::abs(std::abs(p[0]) - 0.5 * size) < 1e-6 * size);
            CHECK(std::abs(std::abs(p[1]) - 0.5 * size) < 1e-6 * size);
          }
        }
      }
}

TEST_CASE("manifold: two capsules side by side touch at both ends of the stretch, crossing ones once") {
  const Shape a(Capsule{0.25, 2}), b(Capsule{0.5, 1});
  const auto side = contacts_of(a, Pose{}, b, Pose::at(0.7, 0, 0.8));
  REQUIRE(side.size() == 2);
  for (const Contact& c : side) {
    CHECK(std::abs(c.depth - 0.05) < 1e-15);
    CHECK(std::abs(c.point.x() - 0.225) < 1e-15);
  }
  CHECK(std::abs(side[0].point.z() - 0.3) < 1e-15);
  CHECK(std::abs(side[1].point.z() - 1.0) < 1e-15);
  Pose crossing = Pose::at(0.7, 0, 0);
  crossing.rotation = Eigen::AngleAxisd(1.0, Vec3::UnitX()).toRotationMatrix();
  CHECK(contacts_of(a, Pose{}, b, crossing).size() == 1);
}

TEST_CASE("box and capsule: the answer certifies itself, apart, shallow and through the middle") {
  Random r(74);
  int inside = 0;
  for (int i = 0; i < 3000; ++i) {
    const Shape box = random_shape(ShapeKind::box, r), capsule = random_shape(ShapeKind::capsule, r);
    const Pose pa = random_pose(r, 0.5);
    Pose pb = random_pose(r, i % 2 == 0 ? 0.3 : 1.2);
    if (i % 5 == 0) pb.rotation = pa.rotation;
    const auto answer = NarrowPhase().solve(box, pa, capsule, pb, Request::distance);
    CAPTURE(i, answer.signed_distance);
    // The separation along the normal is the distance; and the points are on both bodies, so these are nowhere nearer.
    const Vec3 n = answer.normal, m = pa.rotation.transpose() * n;
    const double reach = box.half_size().dot(m.cwiseAbs());
    const double axis = 0.5 * capsule.length() * std::abs(pb.rotation.col(2).dot(n));
    const double apart = n.dot(pb.translation - pa.translation) - reach - axis - capsule.radius();
    CHECK(std::abs(apart - answer.signed_distance) < 1e-14);
    CHECK((answer.point_b - answer.point_a - answer.signed_distance * n).norm() < 1e-12);
    const Vec3 on_box = pa.rotation.transpose() * (answer.point_a - pa.translation);
    CHECK((on_box.cwiseAbs() - box.half_size()).maxCoeff() < 1e-12);
    CHECK(NarrowPhase().solve(box, pa, capsule, pb, Request::collide).collide == answer.collide);
    inside += answer.signed_distance < -capsule.radius() ? 1 : 0;
  }
  CHECK(inside > 300);
}

TEST_CASE("manifold: parallel edges that open by a hair have each end at its own depth") {
  const Shape point(Sphere{0});
  Random r(75);
  const Shape rods[] = {Cylinder{0.3, 1.2}, Capsule{0.2, 1.5}, Cylinder{0.1, 0.7}, Capsule{0.4, 0.5}};
  int two = 0;
  for (const Shape& a : rods)
    for (const Shape& b : rods)
      for (const double tilt : {1e-12, 3e-9, 3e-7, 9e-7}) {
        // Side by side, rotated about the third axis: the gap increases from one end to the other.
        const Pose frame = random_pose(r, 1);
        const Vec3 across(a.radius() + b.radius() + 1e-6, 0, 0.2);
        const Pose local{Eigen::AngleAxisd(tilt, Vec3::UnitY()).toRotationMatrix(), across};
        const Pose pb{frame.rotation * local.rotation, frame * local.translation};
        std::vector<Contact> contacts;
        NarrowPhase({.tolerance = 0, .margin = 1e-5, .solver = {}})
            .solve(a, frame, b, pb, Request::contacts, &contacts);
        CAPTURE(name(a.kind()), name(b.kind()), tilt);
        two += contacts.size() == 2 ? 1 : 0;
        for (const Contact& c : contacts)
          for (const auto& [shape, pose] : {std::pair{a, frame}, std::pair{b, pb}}) {
            const double off = NarrowPhase()
                                   .solve(shape, pose, point, Pose{Mat3::Identity(), c.point}, Request::distance)
                                   .signed_distance;
            CHECK(std::abs(off + 0.5 * c.depth) < 1e-9);
          }
      }
  CHECK(two == 64);
}

TEST_CASE("what touches a half-space by a corner or an edge to rounding has a contact there") {
  const NarrowPhase solver;
  const Shape ground(HalfSpace{{0, -0.70710678118654757, -0.70710678118654757}, 0}), box(Box{{2, 1, 2}}),
      hull(Convex{{{1, 0.5, 1}, {-1, -0.5, -1}, {1, 0.5, -1}, {1, -0.5, 1}}});
  int touching = 0;
  Random r(8);
  for (int k = 0; k < 200; ++k) {
    const double x = r.in(-1, 1), y = k == 0 ? 1 : r.in(-1, 1);
    const Pose pose{Mat3::Identity(), {x, y, 1.5 - y}};
    for (const Shape* shape : {&box, &hull})
      for (const bool swapped : {false, true}) {
        std::vector<Contact> contacts;
        const Pose at{Mat3::Identity(), -pose.translation};
        const PairAnswer answer = swapped ? solver.solve(ground, {}, *shape, at, Request::contacts, &contacts)
                                          : solver.solve(*shape, {}, ground, pose, Request::contacts, &contacts);
        CAPTURE(k, name(shape->kind()), swapped, answer.signed_distance);
        CHECK(std::abs(answer.signed_distance) < 1e-15);
        CHECK(answer.collide == !contacts.empty());
        touching += answer.collide ? 1 : 0;
      }
  }
  CHECK(touching > 50);
}

TEST_CASE("faces that touch to rounding have all of their patch") {
  const NarrowPhase solver;
  const Shape box(Box{{2, 2, 1}}),
      hull(Convex{{{1, 0.5, 0.5}, {-1, 0.5, 0.5}, {0, -1, 0.5}, {1, 0.5, -0.5}, {-1, 0.5, -0.5}, {0, -1, -0.5}}}),
      cylinder(Cylinder{1, 1}), solid(box_mesh({2, 2, 1}));
  const Shape ground(HalfSpace{{0, 0, 1}, 0}),
      slab(Convex{{{9, 9, 0}, {-9, 9, 0}, {9, -9, 0}, {-9, -9, 0}, {0, 0, -5}}}),
      floor(Mesh{{{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}}, {{0, 1, 2}, {0, 2, 3}}});
  int touching = 0;
  Random r(9);
  for (int k = 0; k < 100; ++k) {
    const Mat3 turn = r.rotation();
    const Pose below{turn, Vec3{r.in(-1, 1), r.in(-1, 1), r.in(-1, 1)}};
    const Pose above{turn, below * Vec3{r.in(-1, 1), r.in(-1, 1), 0.5}};
    for (const Shape* lower : {&ground, &slab, &floor})
      for (const Shape* upper : {&box, &hull, &cylinder, &solid}) {
        if (lower == &floor && upper == &solid) continue;  // two meshes: by exact intersections
        std::vector<Contact> contacts;
        const PairAnswer answer = solver.solve(*lower, below, *upper, above, Request::contacts, &contacts);
        CAPTURE(k, name(lower->kind()), name(upper->kind()), answer.signed_distance);
        CHECK(answer.collide == !contacts.empty());
        if (!answer.collide) continue;
        ++touching;
        CHECK(contacts.size() >= (upper == &hull ? 3 : 4));
        for (const Contact& c : contacts) CHECK((c.depth >= 0 && c.depth < 1e-13));
      }
  }
  CHECK(touching > 500);
}

TEST_CASE("contacts lie midway between the surfaces along the normal, on faces and sides that lean") {
  Random r(77);
  const auto prism = [](int sides, double height) {
    std::vector<Vec3> corners;
    for (int k = 0; k < sides; ++k)
      for (const double z : {-height, height})
        corners.emplace_back(std::cos(2 * M_PI * k / sides), std::sin(2 * M_PI * k / sides), z);
    return corners;
  };
  const std::vector<Shape> shapes{Shape(Box{{1, 2, 0.7}}),   Shape(Convex{prism(6, 0.5)}), Shape(Cylinder{0.7, 1}),
                                  Shape(Cone{1, 1}),         Shape(Capsule{0.3, 1.5}),     Shape(Box{{0.3, 0.3, 1}}),
                                  Shape(Cylinder{1.2, 0.1}), Shape(Convex{prism(20, 0.1)})};
  const NarrowPhase solver(NarrowPhaseOptions{.margin = 0.1});
  int leaning = 0;
  for (std::size_t ia = 0; ia < shapes.size(); ++ia)
    for (std::size_t ib = 0; ib < shapes.size(); ++ib)
      for (int i = 0; i < 12; ++i) {
        const Shape &a = shapes[ia], &b = shapes[ib];
        // One lying on the other, a cone's base down and a capsule on its side, up to a degree and a half off.
        const auto lying = [&](const Shape& s, bool above) {
          const bool turned = (s.kind() == ShapeKind::cone) != above;
          const double turn = s.kind() == ShapeKind::capsule ? 0.5 * M_PI : turned ? M_PI : 0;
          return Mat3(Eigen::AngleAxisd(r.in(0, 6), Vec3::UnitZ()) * Eigen::AngleAxisd(turn, Vec3::UnitX()));
        };
        const double lean = i % 4 == 0 ? 1e-4 : r.in(0, 0.025);
        const Pose frame = random_pose(r, 1);
        const Pose pa{frame.rotation * lying(a, false), frame.translation};
        const Mat3 turn = Eigen::AngleAxisd(lean, r.direction()) * lying(b, true);
        Pose pb{frame.rotation * turn, frame * Vec3{r.in(-0.4, 0.4), r.in(-0.4, 0.4), 1}};
        const PairAnswer first = solver.solve(a, pa, b, pb, Request::distance);
        pb.translation -= (first.signed_distance + r.in(-0.02, 0.08)) * first.normal;
        std::vector<Contact> contacts;
        const PairAnswer answer = solver.solve(a, pa, b, pb, Request::contacts, &contacts);
        CAPTURE(ia, ib, i, lean, answer.signed_distance);
        REQUIRE(!contacts.empty());
        leaning += contacts.size() > 1 ? 1 : 0;
        for (const Contact& c : contacts)
          for (const bool of_b : {false, true}) {
            const Vec3 at = c.point + (of_b ? -0.5 : 0.5) * c.depth * c.normal;
            const Pose there{Mat3::Identity(), at};
            const PairAnswer from =
                solver.solve(of_b ? b : a, of_b ? pb : pa, Shape(Sphere{0}), there, Request::distance);
            CHECK(std::abs(from.signed_distance) < 2e-8);
          }
      }
  CHECK(leaning > 500);
}

TEST_CASE("patches: contacts of about one normal are one, found by the deepest, numbered by triangle and place") {
  const Vec3 up(0, 0, 1), leaning = Vec3(0.2, 0, 1).normalized(), down(0, 0, -1);
  PatchCollector patches(1, {});
  patches.add(3, square({0, 0, 0}, up, 0.5));
  patches.add(9, square({5, 0, 0}, leaning, 0.6));
  patches.add(4, square({0, 0, 9}, down, 0.4));
  std::vector<Contact> all(1);
  patches.finish(Vec3::Zero(), false, all);
  REQUIRE(all.size() == 1 + 4 + 4);
  std::size_t of_down = 0;
  double deepest = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const Contact& c = all[i];
    if (i > 1) CHECK(all[i - 1].feature < c.feature);
    deepest = std::max(deepest, c.depth);
    of_down += c.normal == down ? 1u : 0u;
    const std::uint32_t t = c.feature / 64;
    CHECK(c.normal == (t == 4 ? down : t == 9 ? leaning : up));
    const auto given = square(t == 4 ? Vec3(0, 0, 9) : t == 9 ? Vec3(5, 0, 0) : Vec3(0, 0, 0), c.normal, 1);
    CHECK(c.point == given[c.feature % 64].point);
  }
  CHECK(of_down == 4);
  CHECK(deepest == Approx(0.59));
  // Without the deepest, and again with it: no data of one call remain in the other.
  std::vector<Contact> few;
  patches.finish(Vec3::Zero(), false, few, 0.575);
  REQUIRE(few.size() == 8);
  double left = 0;
  for (const Contact& c : few) {
    left = std::max(left, c.depth);
    if (c.feature / 64 == 9) CHECK(c.feature % 64 < 2);  // numbered among the remaining ones
  }
  CHECK(left == Approx(0.57));
  std::vector<Contact> again(1);
  patches.finish(Vec3::Zero(), false, again);
  REQUIRE(again.size() == all.size());
  for (std::size_t i = 1; i < all.size(); ++i)
    CHECK((again[i].point == all[i].point && again[i].feature == all[i].feature));
}

TEST_CASE("patches: of a solid the far side of a wall does not push, of a sheet that only touches both are one") {
  const Vec3 up(0, 0, 1);
  PatchCollector wall(1, {});
  wall.add(1, square({0, 0, 0}, up, 0.5));
  wall.add(2, square({0, 0, -1}, -up, 0.3));
  for (const bool solid : {true, false}) {
    std::vector<Contact> out;
    wall.finish({0, 0, 2}, solid, out);
    CHECK(out.size() == (solid ? 4 : 8));
  }
  PatchCollector sheet(1, {});
  for (const double sign : {1.0, -1.0}) {
    std::vector<Contact> corners = square(Vec3::Zero(), sign * up, 0);
    for (Contact& c : corners) c.depth = 0;
    sheet.add(sign > 0 ? 1 : 2, corners);
  }
  std::vector<Contact> out;
  sheet.finish({0, 0, 2}, false, out);
  CHECK(out.size() == 4);
  for (const Contact& c : out) CHECK(c.normal == up);
}

TEST_CASE("manifold: over a triangle a face is cut as by any other face, also where it lies beside it") {
  Random random(8);
  std::size_t some = 0, none = 0;
  for (int i = 0; i < 4000; ++i) {
    const ShapeKind kinds[] = {ShapeKind::box, ShapeKind::cylinder, ShapeKind::convex};
    const Shape shape = random_shape(kinds[i % 3], random);
    const Vec3 n = random.direction(), u = n.unitOrthogonal(), v = n.cross(u), middle = random.vec(-0.5, 0.5);
    const double width = random.in(0.01, 0.4);
    FlatFeature triangle;
    for (int k = 0; k < 3; ++k) {
      const double along = random.in(-width, width);
      triangle.add(middle + along * u + random.in(-width, width) * v);
    }
    if ((triangle.corner[1] - triangle.corner[0]).cross(triangle.corner[2] - triangle.corner[0]).dot(n) < 0)
      std::swap(triangle.corner[1], triangle.corner[2]);
    triangle.normal = n;
    const FlatFeature face = best_face(view(shape), -n);
    if (!face.is_face()) continue;
    constexpr double everything = 10;
    PatchPoint quick[max_patch], cut[max_patch];
    const int count = clip_over_triangle(triangle, face, everything, everything, 1e-9, quick);
    CAPTURE(i, name(shape.kind()), count);
    REQUIRE(count == clip_faces(triangle, face, n, false, everything, everything, 1e-9, cut));
    for (int k = 0; k < count; ++k) {
      CHECK(quick[k].at == cut[k].at);
      CHECK(quick[k].depth == cut[k].depth);
    }
    ++(count == 0 ? none : some);
  }
  CHECK(std::min(some, none) > 300);
}

TEST_CASE("manifold: the plane of a mesh's sliver passes through its corners") {
  Random random(9);
  for (int i = 0; i < 4000; ++i) {
    const Vec3 along = random.direction(), across = along.unitOrthogonal(), first = random.vec(-0.5, 0.5);
    const double height = std::pow(10.0, -random.in(0, 12));
    const std::array corners{first, Vec3(first + along), Vec3(first + random.unit() * along + height * across)};
    const TriangleView sliver(corners);
    const FlatFeature face = best_face(sliver, random.direction());
    CAPTURE(i, height);
    REQUIRE(face.count == 3);
    for (int k = 1; k < 3; ++k) CHECK(std::abs(face.normal.dot(face.corner[k] - face.corner[0])) < 1e-15);
  }
}

TEST_CASE("contacts within a margin of the distance, or of a few last digits more or less, lie between the surfaces") {
  Random r(5);
  std::vector<ShapeKind> kinds(std::begin(bounded_convex), std::end(bounded_convex));
  kinds.push_back(ShapeKind::mesh);
  kinds.push_back(ShapeKind::voxels);
  std::size_t found = 0;
  for (const ShapeKind kind_a : kinds)
    for (const ShapeKind kind_b : kinds)
      for (int i = 0; i < 60; ++i) {
        const Shape plain_a = random_shape(kind_a, r), plain_b = random_shape(kind_b, r);
        const Shape a = i % 5 == 0 ? plain_a.rounded(r.in(0.01, 0.4)) : plain_a,
                    b = i % 7 == 0 ? plain_b.rounded(r.in(0.01, 0.4)) : plain_b;
        const Pose pa = random_pose(r, 1.5), pb = random_pose(r, 1.5);
        const PairAnswer nearest = NarrowPhase().solve(a, pa, b, pb, Request::distance);
        if (nearest.collide) continue;
        NarrowPhaseOptions options;
        options.margin = std::max(nearest.signed_distance + (r.below(9) - 4) * 0x1p-53, 0.0);
        std::vector<Contact> contacts;
        const PairAnswer answer = NarrowPhase(options).solve(a, pa, b, pb, Request::contacts, &contacts);
        CAPTURE(name(kind_a), name(kind_b), i, options.margin, nearest.signed_distance, answer.signed_distance);
        CHECK((answer.signed_distance > options.margin + 1e-14) <= contacts.empty());
        found += contacts.size();
        for (const Contact& c : contacts)
          for (const bool of_b : {false, true}) {
            const Pose there{Mat3::Identity(), c.point + (of_b ? -0.5 : 0.5) * c.depth * c.normal};
            const double off = NarrowPhase()
                                   .solve(of_b ? b : a, of_b ? pb : pa, Shape(Sphere{0}), there, Request::distance)
                                   .signed_distance;
            CHECK(std::abs(off) < 1e-7);
          }
      }
  CHECK(found > 1000);
}
