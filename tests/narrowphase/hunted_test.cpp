// Pairs for which random searches against the reference once found wrong answers, with random pairs of their kind.
#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "catch.h"
#include "judge.h"
#include "manifold/patch_collector.h"
#include "mesh_samples.h"
#include "pair_classes.h"
#include "random_pairs.h"
#include "reference.h"

using namespace tandem;
using namespace tandem::test;

namespace {

constexpr double full_turn = 6.283185307179586;

/// A shape with flat faces along its axes, `scale` in size.
Shape faced_shape(int which, Random& r, double scale) {
  const Vec3 size = scale * r.vec(0.02, 2);
  switch (which) {
    case 0:
      return Box{size};
    case 1: {
      Convex c;
      const int sides = 3 + r.below(8);
      for (int i = 0; i < sides; ++i)
        for (const double h : {-0.5, 0.5})
          c.vertices.emplace_back(size[0] * std::cos(full_turn * i / sides), size[1] * std::sin(full_turn * i / sides),
                                  h * size[2]);
      return Shape(c);
    }
    default:
      return Triangle{{Vec3(size[0], 0, 0), Vec3(-size[0], size[1], 0), Vec3(-size[0] * r.unit(), -size[1], 0)}};
  }
}

/// Quarter turns, then a slight rotation.
Mat3 almost_aligned(Random& r) {
  Mat3 m = Mat3::Identity();
  for (int k = r.below(4); k > 0; --k) m = (Mat3() << 0, -1, 0, 1, 0, 0, 0, 0, 1).finished() * m;
  for (int k = r.below(3); k > 0; --k) m = (Mat3() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished() * m;
  const double tilt = r.once_in(5) ? 0 : std::pow(10.0, r.in(-11, -2));
  const Vec3 axis = r.once_in(3) ? Vec3(Vec3::Unit(r.below(3))) : r.direction();
  return m * Eigen::AngleAxisd(tilt, axis).toRotationMatrix();
}

// A solid extruded along y from its profile, counterclockwise as seen from smaller y, and the profile's triangles.
Mesh prism(const std::vector<Vec3>& profile, const std::vector<std::array<std::uint32_t, 3>>& cap, double width) {
  Mesh m;
  m.solid = true;
  const auto n = static_cast<std::uint32_t>(profile.size());
  for (const double y : {-width / 2, width / 2})
    for (const Vec3& p : profile) m.vertices.push_back(p + Vec3(0, y, 0));
  for (const auto& t : cap) {
    m.triangles.push_back({t[0], t[1], t[2]});
    m.triangles.push_back({n + t[0], n + t[2], n + t[1]});
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    m.triangles.push_back({i, n + i, n + next});
    m.triangles.push_back({i, n + next, next});
  }
  return m;
}

// A star of six points about y.
Mesh star(double width) {
  constexpr std::uint32_t points = 6;
  std::vector<Vec3> profile;
  std::vector<std::array<std::uint32_t, 3>> cap;
  for (std::uint32_t i = 0; i < 2 * points; ++i) {
    const double angle = full_turn * i / (2 * points), radius = i % 2 == 0 ? 1 : 0.6;
    profile.emplace_back(radius * std::cos(angle), 0, radius * std::sin(angle));
    if (i % 2 == 0) cap.push_back({(i + 2 * points - 1) % (2 * points), i, i + 1});
  }
  for (std::uint32_t i = 3; i + 2 < 2 * points; i += 2) cap.push_back({1, i, i + 2});
  return prism(profile, cap, width);
}

}  // namespace

TEST_CASE("hunted: almost aligned flat faces that hardly touch, sizes up to 1000 apart") {
  const NarrowPhase solver;
  for (std::uint64_t i = 0; i < 2500; ++i) {
    Random r(i * 31 + 7);
    const double scale = std::pow(10.0, r.in(-3, 3));
    const int which_a = r.below(3), which_b = r.below(3);
    const Shape a = faced_shape(which_a, r, 1), b = faced_shape(which_b, r, scale);
    const double gap = r.once_in(6) ? 0 : r.sign() * std::pow(10.0, r.in(-16, -6));
    reference::PosedPair p{a, {}, b, {}};
    if (r.once_in(2)) p.pose_a.rotation = r.rotation();
    p.pose_b.rotation = p.pose_a.rotation * almost_aligned(r);
    const double across = r.once_in(2) ? 1 + scale : std::abs(1 - scale);
    const Vec3 side = 0.5 * across * r.vec(-1, 1);
    const double sign = r.sign();
    p.pose_b.translation = p.pose_a.rotation * (side + 3 * (1 + scale) * sign * Vec3::Unit(r.below(3)));
    for (int k = 0; k < 3; ++k) {
      const auto t = reference::signed_distance(a, p.pose_a, b, p.pose_b);
      p.pose_b.translation -= (t.signed_distance - gap) * t.normal;
    }
    const reference::Truth t = reference::signed_distance(a, p.pose_a, b, p.pose_b);
    const PairAnswer x = solver.solve(a, p.pose_a, b, p.pose_b, Request::distance);
    const double size = reference::size(p), reach = p.pose_b.translation.norm();
    CAPTURE(i, t.signed_distance, x.signed_distance, size, record(p));
    CHECK(std::abs(x.signed_distance - t.signed_distance) <= 1e-12 * size + 1e-15 * reach);
    if (std::abs(t.signed_distance) > 1e-15 * size + 4e-16 * reach) CHECK(x.collide == (t.signed_distance <= 0));
    // At contact any normal of a normal cone separates, but not any direction.
    CHECK(reference::separation(a, p.pose_a, b, p.pose_b, x.normal) >= t.signed_distance - 1e-12 * size);
    CHECK((x.point_b - x.point_a - x.signed_distance * x.normal).norm() <= 1e-11 * size);
  }
}

TEST_CASE("hunted: boxes 1e-9 and less apart whose points' direction is noise") {
  const auto turned = [](double x, double angle) {
    Pose p;
    p.rotation =
        (Mat3() << 1, 0, 0, 0, std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle)).finished();
    p.translation[0] = x;
    return p;
  };
  Pose first = turned(0.026896285610264484, 1e-5), second = turned(0.069772999944322164, 1e-6);
  first.translation = {0.026896285610264484, -0.42288028716608739, 0.37407001873456314};
  second.translation = {0.069772999944322164, 0.11950868843480288, 0.033115095355555797};
  const reference::PosedPair pairs[] = {
      {Shape(Box{{0.050948812623382911, 1.2909568249197878, 0.7472229504011717}}),
       {},
       Shape(Box{{0.0028437585939809075, 0.0023763900535081514, 0.00091706328435190603}}),
       first},
      {Shape(Box{{0.13689728329256454, 0.41497552152916906, 0.065958676789020565}}),
       {},
       Shape(Box{{0.002648716593884859, 0.0030547116407284051, 0.00027151084750033449}}),
       second}};
  for (const auto& p : pairs) {
    const reference::Truth t = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
    CHECK(judge(NarrowPhase(), p, t) == "");
  }
}

TEST_CASE("hunted: ellipsoids deep in shapes with edges and in each other have their least depth") {
  const struct {
    ShapeKind a, b;
    std::vector<std::uint64_t> indices;
  } rows[] = {{ShapeKind::ellipsoid, ShapeKind::ellipsoid, {20276, 20425}},
              {ShapeKind::box, ShapeKind::ellipsoid, {20550}},
              {ShapeKind::capsule, ShapeKind::ellipsoid, {20632}},
              {ShapeKind::cylinder, ShapeKind::ellipsoid, {10071, 20019, 20214, 50100, 50133, 51123, 51134, 51501}},
              {ShapeKind::cone, ShapeKind::ellipsoid, {10063, 20671, 51320, 52670, 53070, 53846}}};
  const NarrowPhase solver;
  for (const auto& row : rows)
    for (const std::uint64_t index : row.indices) {
      const auto p = reference::make_pair({row.a, 0}, {row.b, 0}, reference::PairClass::deep, index);
      const reference::Truth t = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
      CAPTURE(name(row.a), name(row.b), index);
      CHECK(judge(solver, p, t) == "");
    }
}

TEST_CASE("hunted: a least depth all around an axis, or in all directions, is known to be the least") {
  // A body about its z axis, and its support when it leans by the angle of this sine and cosine.
  struct Turned {
    Shape shape;
    std::function<double(double, double)> reach;
  };
  const auto spheroid = [](double r, double z) {
    return Turned{Ellipsoid{{r, r, z}}, [=](double s, double c) { return std::hypot(r * s, z * c); }};
  };
  const auto others = [&](double f) {
    const Vec3 tip(0, 0, f);
    const auto segment = [=](double, double c) { return f * std::abs(c); };
    return std::vector<Turned>{
        {Cylinder{f, f}, [=](double s, double c) { return f * (s + 0.5 * std::abs(c)); }},
        {Cylinder{f / 3, 3 * f}, [=](double s, double c) { return f * (s / 3 + 1.5 * std::abs(c)); }},
        {Capsule{f / 2, f}, [=](double, double c) { return f * (0.5 + 0.5 * std::abs(c)); }},
        {Cone{f / 3, 3 * f}, [=](double s, double c) { return f * std::max(1.5 * c, s / 3 - 1.5 * c); }},
        {Shape(Convex{{tip, -tip, 0.25 * tip}}), segment},
        {Triangle{{tip, 0.4 * tip, -tip}}, segment},
        spheroid(f, 9 * f)};
  };
  const NarrowPhase solver;
  Random r(5);
  std::size_t wrong = 0;
  const auto check = [&](const Turned& a, const Turned& b, double up) {
    const auto h = [&](double angle) {
      const double s = std::sin(angle), c = std::cos(angle);
      return a.reach(s, c) + b.reach(s, -c) - up * c;
    };
    constexpr int samples = 2000;
    const double step = 0.5 * full_turn / samples;
    int lowest = 0;
    for (int i = 1; i <= samples; ++i)
      if (h(i * step) < h(lowest * step)) lowest = i;
    double low = std::max(0, lowest - 1) * step, high = std::min(samples, lowest + 1) * step;
    for (int i = 0; i < 100; ++i) {
      const double p = low + (high - low) / 3, q = high - (high - low) / 3;
      (h(p) < h(q) ? high : low) = h(p) < h(q) ? q : p;
    }
    const double truth = std::min({h(low), h(0), h(0.5 * full_turn)}), size = a.shape.size() + b.shape.size();
    const Pose at_a{r.rotation(), r.vec(-1, 1)}, at_b{at_a.rotation, at_a.translation + up * at_a.rotation.col(2)};
    const PairAnswer answer = solver.solve(a.shape, at_a, b.shape, at_b, Request::distance);
    wrong += answer.status == Status::ok && std::abs(answer.signed_distance + truth) <= 1e-12 * size ? 0 : 1;
  };
  for (const double f : {0.01, 0.3, 1.0, 30.0})
    for (const double up : {0.0, 0.2})
      for (const Turned& b : others(f)) {
        for (const auto& [radius, along] : {std::pair{1.0, 0.5}, {1.0, 2.0}, {1.0, 10.0}, {1.0, 0.1}, {0.5, 0.9}})
          check(spheroid(radius, along), b, up);
        if (b.shape.kind() == ShapeKind::convex || b.shape.kind() == ShapeKind::triangle)
          for (const Turned& a : others(0.7)) check(a, b, up);
      }
  CHECK(wrong == 0);

  // An ellipsoid of one radius is a ball.
  wrong = 0;
  for (int i = 0; i < 400; ++i) {
    const double radius = std::pow(10.0, r.in(-3, 2));
    const Shape other = random_shape(bounded_convex[static_cast<std::size_t>(i) % std::size(bounded_convex)], r);
    const Pose at_other{r.rotation(), r.once_in(2) ? Vec3(Vec3::Zero()) : r.vec(-0.1, 0.1)};
    const PairAnswer ball = solver.solve(Sphere{radius}, {}, other, at_other, Request::distance);
    const PairAnswer answer =
        solver.solve(Ellipsoid{{radius, radius, radius * (1 + 2e-16)}}, {}, other, at_other, Request::distance);
    const double rounding = 1e-14 * (2 * radius + other.size());
    wrong += answer.status == Status::ok && std::abs(answer.signed_distance - ball.signed_distance) <= rounding ? 0 : 1;
  }
  CHECK(wrong == 0);
}

TEST_CASE("hunted: contacts of solids and discs that lie flat stay where they are when moved by 1e-9") {
  const NarrowPhase solver;
  int flat = 0;
  for (std::uint64_t i = 0; i < 120; ++i) {
    Random r(i * 7919 + 17);
    const Vec3 size = r.vec(0.5, 1.5);
    Mesh mesh = box_mesh(size, 1 + r.below(3)), other = box_mesh(r.vec(0.5, 0.9), 2);
    const Shape a(mesh), b = r.once_in(2) ? Shape(other) : Shape(Cylinder{0.3, r.in(0.4, 0.7)});
    Pose pa, pb;
    if (r.once_in(2)) pa.rotation = r.rotation();
    pb.rotation = pa.rotation;
    const Vec3 axis = pa.rotation.col(2);
    pb.translation = 3 * axis + pa.rotation * Vec3{r.in(-0.1, 0.1), r.in(-0.1, 0.1), 0};
    const double depth = std::min(r.power_of_two(-20, -6), 1e-2);
    pb.translation -= (solver.solve(a, pa, b, pb, Request::distance).signed_distance + depth) * axis;
    Pose moved = pb;
    moved.translation += 1e-9 * r.direction();
    moved.rotation = Eigen::AngleAxisd(1e-9, r.direction()).toRotationMatrix() * moved.rotation;
    std::vector<Contact> before, after;
    solver.solve(a, pa, b, pb, Request::contacts, &before);
    solver.solve(a, pa, b, moved, Request::contacts, &after);
    CAPTURE(i, name(b.kind()), depth);
    REQUIRE(before.size() == after.size());
    flat += before.size() == 4;
    for (std::size_t k = 0; k < before.size(); ++k) {
      CHECK((before[k].point - after[k].point).norm() < 1e-7);
      CHECK((before[k].normal - after[k].normal).norm() < 1e-7);
      CHECK(std::abs(before[k].depth - depth) < 1e-7);
    }
  }
  CHECK(flat > 100);
}

TEST_CASE("hunted: the faces of slivers are as exact turned as they are given") {
  const NarrowPhase solver;
  const auto check = [&](const reference::PosedPair& p) {
    const auto truth = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
    CHECK(judge(solver, p, truth) == "");
  };
  const Pose pose_a{
      (Mat3() << -0.89477653345585662, 0.42073503327072598, 0.14952252992576481, 0.2303470936034297,
       0.14807897346382903, 0.96177587518420904, 0.38251166210348791, 0.89501656375543115, -0.2294126826447207)
          .finished(),
      {-0.094864724810740819, -0.036460960078012583, -0.52610841940149244}};
  const Pose pose_b{
      (Mat3() << 0.64381379090982893, 0.63838847755680828, -0.42185774184790703, -0.76512148414694625,
       0.5440338622770482, -0.34440712999688605, 0.0096393532505688884, 0.54450648152121939, 0.83870124266647694)
          .finished(),
      {-0.48863432714517208, -0.62637356552538692, -0.68977620049084343}};
  const Shape sliver(Triangle{{Vec3(-1.4229929229753531, -1.1079264239940367, -1.028933835566104),
                               Vec3(1.527669890116625, 1.0236586144728488, -1.0346823175158719),
                               Vec3(-0.24272582171965121, -0.25529027298975282, -1.0312324404546107)}});
  check({sliver, pose_a, Box{Vec3(0.51255378542001484, 0.3991834495737705, 1.2874477324391309)}, pose_b});
  for (std::uint64_t i = 0; i < 300; ++i) {
    Random r(i * 17 + 3);
    const Vec3 p = r.vec(-1, 1), q = r.vec(-1, 1);
    const double height = std::pow(10.0, r.in(-5, -1));
    const Shape thin(Triangle{{p, q, 0.6 * p + 0.4 * q + height * r.direction()}});
    const Shape other = random_shape(i % 2 == 0 ? ShapeKind::box : ShapeKind::convex, r);
    const Pose at = random_pose(r, 1);
    reference::PosedPair pair{thin, at, other, {r.rotation(), at * Vec3(0.5 * (p + q))}};
    const auto truth = reference::signed_distance(pair.a, pair.pose_a, pair.b, pair.pose_b);
    pair.pose_b.translation += (-std::pow(10.0, r.in(-9, -5)) - truth.signed_distance) * truth.normal;
    check(pair);
  }
}

TEST_CASE("hunted: a short capsule is a ball to its length, also where rounding swallows its axis") {
  Convex hull;
  for (int i = 0; i < 12; ++i)
    hull.vertices.emplace_back(std::cos(full_turn * i / 12), std::sin(full_turn * i / 12), i % 2 == 0 ? 0.5 : -0.5);
  const std::vector<Shape> others = {Cylinder{2, 20}, Cone{2, 3},
                                     Shape(hull),     Ellipsoid{{1, 2, 3}},
                                     Box{{1, 2, 3}},  Triangle{{Vec3(3, 0, 0), Vec3(-2, 2, 0), Vec3(-2, -2, 0.5)}}};
  const NarrowPhase solver;
  std::size_t wrong = 0;
  for (std::uint64_t i = 0; i < 60000; ++i) {
    Random r(i * 17 + 3);
    const Shape& other = others[i % others.size()];
    const double radius = std::pow(10.0, r.in(-4, 0));
    const Capsule capsule{radius, r.once_in(3) ? 0 : std::pow(10.0, r.in(-29, -1))};
    Pose at_other{almost_aligned(r), r.vec(-3, 3)};
    if (r.once_in(3)) at_other.rotation = r.rotation();
    const PairAnswer answer = solver.solve(capsule, {}, other, at_other, Request::distance);
    const PairAnswer expected = solver.solve(Sphere{radius}, {}, other, at_other, Request::distance);
    const double rounding = 1e-14 * (other.size() + 2 * radius);
    wrong += answer.status == Status::ok &&
                     std::abs(answer.signed_distance - expected.signed_distance) <= rounding + 0.5 * capsule.length
                 ? 0
                 : 1;
    const bool collide = solver.solve(capsule, {}, other, at_other, Request::collide).collide;
    wrong +=
        collide == expected.collide || std::abs(expected.signed_distance) <= rounding + 0.5 * capsule.length ? 0 : 1;
  }
  CHECK(wrong == 0);
}

TEST_CASE("hunted: bodies that lie on a floor of few triangles, wound any way, have the points of a flat one") {
  // On a diagonal that meets their corners each triangle has its own points; a surface has two sides, whatever the
  // orientation of its triangles.
  const NarrowPhase solver;
  const auto prism = [](int sides, double height) {
    Mesh m;
    m.solid = true;
    for (const double z : {-height / 2, height / 2})
      for (int i = 0; i < sides; ++i)
        m.vertices.emplace_back(std::cos(full_turn * i / sides), std::sin(full_turn * i / sides), z);
    const auto n = static_cast<std::uint32_t>(sides);
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t next = (i + 1) % n;
      m.triangles.push_back({i, next, n + next});
      m.triangles.push_back({i, n + next, n + i});
      if (i == 0 || next == 0) continue;
      m.triangles.push_back({0, next, i});
      m.triangles.push_back({n, n + i, n + next});
    }
    return m;
  };
  const auto hull = [](const Mesh& m) { return Shape(Convex{m.vertices}); };
  struct Body {
    Shape shape;
    double height, least_area;
  };
  std::vector<Body> bodies{{Box{Vec3(1, 2, 0.5)}, 0.25, 2}, {Cylinder{1, 0.4}, 0.2, 1.9}};
  for (const int sides : {3, 4, 5, 6, 8, 12}) {
    const double area = sides == 3 ? 1.29 : 1.7;
    bodies.push_back({hull(prism(sides, 0.5)), 0.25, area});
    bodies.push_back({Shape(prism(sides, 2)), 1, area});
  }
  for (const int winding : {0, 1, 2, 3}) {
    Mesh floor{{{-3, -3, 0}, {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}}, {{0, 1, 2}, {0, 2, 3}}};
    for (std::uint32_t k = 0; k < 2; ++k)
      if (winding >> k & 1) std::swap(floor.triangles[k][1], floor.triangles[k][2]);
    for (const Body& body : bodies)
      for (const double spin : {0.0, full_turn / 8, 0.3})
        for (const double sunk : {1e-8, 1e-4}) {
          CAPTURE(winding, &body - bodies.data(), spin, sunk);
          const Mat3 tilted = Quat(0.7, 0.2, -0.4, 0.5).normalized().toRotationMatrix();
          const Pose ground{tilted, Vec3(0.3, -0.2, 0.1)};
          const Pose own{Eigen::AngleAxisd(spin, Vec3::UnitZ()).toRotationMatrix(), Vec3(0, 0, body.height - sunk)};
          const Pose at{tilted * own.rotation, ground * own.translation};
          const auto contacts_at = [&](const Pose& pose) {
            std::vector<Contact> contacts;
            solver.solve(Shape(floor), ground, body.shape, pose, Request::contacts, &contacts);
            for (Contact& c : contacts) c.point = tilted.transpose() * (c.point - ground.translation);
            return contacts;
          };
          const std::vector<Contact> contacts = contacts_at(at);
          REQUIRE(contacts.size() == (body.least_area == 1.29 ? 3 : 4));
          Vec3 centre = Vec3::Zero();
          for (const Contact& c : contacts) {
            CHECK(c.depth == Approx(sunk).epsilon(0).margin(1e-14));
            CHECK((c.normal - tilted.col(2)).norm() < 1e-12);
            centre += c.point / static_cast<double>(contacts.size());
          }
          std::vector<Vec3> around;
          for (const Contact& c : contacts) around.push_back(c.point - centre);
          std::sort(around.begin(), around.end(),
                    [](const Vec3& p, const Vec3& q) { return std::atan2(p.y(), p.x()) < std::atan2(q.y(), q.x()); });
          double area = 0;
          for (std::size_t k = 0; k < around.size(); ++k)
            area += 0.5 * around[k].cross(around[(k + 1) % around.size()]).z();
          CHECK(area > body.least_area - 1e-7);
          Random r(static_cast<std::uint64_t>(&body - bodies.data()) * 7 + 3);
          for (int i = 0; i < 4; ++i) {
            const Pose moved{Eigen::AngleAxisd(1e-9, r.direction()).toRotationMatrix() * at.rotation,
                             at.translation + 1e-9 * r.direction()};
            const std::vector<Contact> there = contacts_at(moved);
            REQUIRE(there.size() == contacts.size());
            for (const Contact& c : there)
              CHECK(std::any_of(contacts.begin(), contacts.end(),
                                [&](const Contact& o) { return (o.point - c.point).norm() < 1e-7; }));
          }
        }
  }
}

TEST_CASE("hunted: a surface pushes to the nearer of its sides, whichever way its triangles go round") {
  const NarrowPhase solver;
  const auto surface = [](Mesh m, bool inside_out) {
    m.solid = false;
    if (inside_out)
      for (auto& t : m.triangles) std::swap(t[1], t[2]);
    return m;
  };
  Mesh odd = surface(box_mesh(Vec3(1, 1, 1), 2), false);
  for (std::size_t i = 0; i < odd.triangles.size(); i += 3) std::swap(odd.triangles[i][1], odd.triangles[i][2]);
  const Shape bodies[] = {Shape(surface(box_mesh(Vec3(1, 1, 1)), false)), Shape(surface(box_mesh(Vec3(1, 1, 1)), true)),
                          Shape(odd), Shape(torus(1, 0.5, 12, 8)), Shape(surface(torus(1, 0.5, 12, 8), true))};
  for (int winding = 0; winding < 16; ++winding) {
    Mesh floor;
    for (const double x : {-5.0, 0.3, 5.0})
      for (const double y : {-4.0, 6.0}) floor.vertices.emplace_back(x, y, 0);
    floor.triangles = {{0, 2, 3}, {0, 3, 1}, {2, 4, 5}, {2, 5, 3}};
    for (std::uint32_t k = 0; k < 4; ++k)
      if (winding >> k & 1) std::swap(floor.triangles[k][1], floor.triangles[k][2]);
    for (const Shape& body : bodies)
      for (const double sunk : {1e-6, 1e-3})
        for (const bool below : {false, true}) {
          CAPTURE(winding, &body - bodies, sunk, below);
          const double side = below ? -1 : 1;
          const Pose ground{Quat(0.7, 0.2, -0.4, 0.5).normalized().toRotationMatrix(), Vec3(0.3, -0.2, 0.1)};
          const Pose at{ground.rotation, ground * Vec3(0.1, 0.2, side * (0.5 - sunk))};
          for (const bool exchanged : {false, true}) {
            std::vector<Contact> contacts;
            exchanged ? solver.solve(body, at, Shape(floor), ground, Request::contacts, &contacts)
                      : solver.solve(Shape(floor), ground, body, at, Request::contacts, &contacts);
            REQUIRE(contacts.size() >= 3);
            for (const Contact& c : contacts) {
              CHECK(c.depth <= sunk + 1e-12);
              CHECK((c.normal - (exchanged ? -side : side) * ground.rotation.col(2)).norm() < 1e-6);
            }
            CHECK(std::any_of(contacts.begin(), contacts.end(),
                              [&](const Contact& c) { return c.depth >= sunk - 1e-12; }));
          }
        }
  }
}

TEST_CASE(
    "hunted: closed surfaces that are their own hull meet as what they bound, where that is the least translation") {
  const NarrowPhase solver;
  const auto surface = [](const Vec3& size, int n) {
    Mesh m = box_mesh(size, n);
    m.solid = false;
    return Shape(m);
  };
  const auto contacts_of = [&](const Shape& a, const Pose& pa, const Shape& b, const Pose& pb) {
    std::vector<Contact> contacts;
    solver.solve(a, pa, b, pb, Request::contacts, &contacts);
    return contacts;
  };
  const auto deepest_of = [](const std::vector<Contact>& contacts) {
    double deepest = 0;
    for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
    return deepest;
  };
  const Vec3 size(1, 0.8, 0.6);
  Random r(71);
  SECTION("on an edge or a corner, on floors of triangles") {
    Mesh floor{{{-3, -3, 0}, {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}, {0.1, 0.2, 0}},
               {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}};
    for (const int n : {1, 2})
      for (int i = 0; i < 60; ++i) {
        const Mat3 turned = i % 2 == 0 ? Mat3(Eigen::AngleAxisd(r.unit() * full_turn, Vec3::UnitZ()) *
                                              Eigen::AngleAxisd(0.3 + 0.9 * r.unit(), Vec3::UnitX()))
                                       : r.rotation();
        const double low = (turned.row(2).transpose().cwiseProduct(size / 2)).lpNorm<1>();
        const double sunk = i % 3 == 0 ? 1e-7 : i % 3 == 1 ? 1e-4 : 1e-2;
        const Pose at{turned, Vec3{r.unit(), r.unit(), low - sunk}};
        CAPTURE(n, i, sunk);
        const std::vector<Contact> contacts = contacts_of(Shape(floor), Pose{}, surface(size, n), at);
        CHECK(deepest_of(contacts) == Approx(sunk).epsilon(0).margin(1e-12));
        for (const Contact& c : contacts) CHECK((c.normal - Vec3::UnitZ()).norm() < 1e-9);
        const PairAnswer d = solver.solve(Shape(floor), Pose{}, surface(size, n), at, Request::distance);
        CHECK(d.status == Status::ok);
        CHECK(d.signed_distance == Approx(-sunk).epsilon(0).margin(1e-12));
      }
  }
  SECTION("a corner or an edge in another's face or edge") {
    for (int i = 0; i < 100; ++i) {
      const Mat3 ra = i % 2 == 0 ? Mat3(Mat3::Identity()) : r.rotation();
      const Mat3 rb = r.rotation();
      const double high = (ra.row(2).transpose().cwiseProduct(size / 2)).lpNorm<1>(),
                   low = (rb.row(2).transpose().cwiseProduct(size / 2)).lpNorm<1>();
      const Pose pa{ra, Vec3::Zero()}, pb{rb, Vec3{0.2 * r.unit(), 0.2 * r.unit(), high + low - 0.01}};
      CAPTURE(i);
      const Shape box(Box{size});
      const PairAnswer want = solver.solve(box, pa, box, pb, Request::distance);
      const Shape other = surface(size, 1 + i % 3);
      const std::vector<Contact> contacts = contacts_of(surface(size, 1), pa, other, pb);
      if (!want.collide) continue;
      CHECK(deepest_of(contacts) == Approx(-want.signed_distance).epsilon(0).margin(1e-12));
      CHECK(contacts.size() == contacts_of(box, pa, box, pb).size());
    }
  }
  SECTION("what is nearly inside a surface is not pushed out of it through what it bounds") {
    const Shape large = surface(Vec3(4, 4, 4), 1), solid(box_mesh(Vec3(1, 1, 1)));
    const Pose through{Mat3::Identity(), Vec3(1.55, 0.1, 0.2)};
    for (const Shape& small : {surface(Vec3(1, 1, 1), 1), solid}) {
      CHECK(solver.solve(large, Pose{}, small, through, Request::distance).signed_distance == Approx(-0.05));
      CHECK(deepest_of(contacts_of(large, Pose{}, small, through)) == Approx(0.05));
    }
    const Shape plate(Mesh{{{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}}, {{0, 1, 2}, {0, 2, 3}}});
    CHECK(deepest_of(contacts_of(large, Pose{}, plate, through)) == Approx(0.05));
  }
}

TEST_CASE("hunted: points that lie on each other but for rounding are kept once each, the deepest depth is") {
  for (int n = 2; n <= 7; ++n)
    for (std::uint64_t i = 0; i < 200; ++i) {
      Random r(i * 613 + static_cast<std::uint64_t>(n));
      std::vector<Contact> contacts;
      contacts.reserve(16);
      const Vec3 normal = r.direction(), along = normal.unitOrthogonal(), side = normal.cross(along);
      const double length = r.power_of_two(-32, -24), width = r.power_of_two(-32, -24);  // about the slack of unit size
      for (int k = 0; k < n; ++k) {
        const double u = length * r.unit(), v = width * r.unit();
        contacts.push_back({u * along + v * side, normal, 1e-8 * r.unit(), static_cast<std::uint32_t>(k)});
      }
      const std::vector<Contact> all = contacts;
      const auto shallower = [](const Contact& x, const Contact& y) { return x.depth < y.depth; };
      keep_widest(contacts, 0, 1);
      CAPTURE(n, i);
      REQUIRE(!contacts.empty());
      REQUIRE(contacts.size() <= 4);
      CHECK(std::max_element(contacts.begin(), contacts.end(), shallower)->depth ==
            std::max_element(all.begin(), all.end(), shallower)->depth);
      for (std::size_t k = 0; k < contacts.size(); ++k) {
        CHECK(std::any_of(all.begin(), all.end(), [&](const Contact& c) { return c.point == contacts[k].point; }));
        for (std::size_t l = 0; l < k; ++l) CHECK(contacts[l].point != contacts[k].point);
      }
    }
}

TEST_CASE("hunted: between several walls the translation out is the shortest beyond all of them") {
  // Rooms whose free space is convex: x >= 0 and z >= 0, and y >= 0 for the last; or z above |x| / 2.
  const NarrowPhase solver;
  const auto wall = [](Mesh& m, const Vec3& corner, const Vec3& u, const Vec3& v, int n) {
    const auto first = static_cast<std::uint32_t>(m.vertices.size()), row = static_cast<std::uint32_t>(n + 1);
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) m.vertices.emplace_back(corner + (i * u + j * v) / n);
    for (std::uint32_t i = 0; i + 1 < row; ++i)
      for (std::uint32_t j = 0; j + 1 < row; ++j) {
        const std::uint32_t a = first + i * row + j, b = a + row;
        m.triangles.push_back({a, b, b + 1});
        m.triangles.push_back({a, b + 1, a + 1});
      }
  };
  const Vec3 x = 4 * Vec3::UnitX(), y = 4 * Vec3::UnitY(), z = 4 * Vec3::UnitZ();
  const std::vector<Shape> bodies{Box{Vec3(1, 0.8, 0.6)},
                                  Sphere{0.4},
                                  Capsule{0.2, 0.7},
                                  Cylinder{0.3, 0.6},
                                  Shape(Convex{box_mesh(Vec3(0.7, 0.5, 0.9)).vertices}),
                                  Shape(box_mesh(Vec3(0.7, 0.9, 0.5), 2))};
  Random r(5);
  for (const int kind : {0, 1, 2})
    for (const int n : {1, 3, 8}) {
      Mesh room;
      std::vector<Vec3> normals;
      if (kind < 2) {
        wall(room, -y / 2 * (1 - kind), x, y, n);
        wall(room, -y / 2 * (1 - kind), y, z, n);
        normals = {Vec3::UnitZ(), Vec3::UnitX()};
        if (kind == 1) wall(room, Vec3::Zero(), z, x, n), normals.push_back(Vec3::UnitY());
      } else {
        for (const double side : {-1.0, 1.0}) {
          wall(room, -y / 2, side * x + z / 2, y, n);
          normals.push_back(Vec3(-side, 0, 2).normalized());
        }
      }
      const Shape shape(room);
      for (const Shape& body : bodies)
        for (int i = 0; i < 6; ++i) {
          CAPTURE(kind, n, &body - bodies.data(), i);
          const double sunk = i % 3 == 0 ? 1e-7 : i % 3 == 1 ? 1e-4 : 5e-3;
          Pose pose;
          if (i % 2 != 0) pose.rotation = Eigen::AngleAxisd(full_turn / 4, Vec3::UnitY()).toRotationMatrix();
          Mat3 rows = Mat3::Identity();
          Vec3 level(0, 0.3 * r.unit(), 0);
          for (std::size_t k = 0; k < normals.size(); ++k) {
            const auto row = static_cast<Eigen::Index>(k == 1 ? 0 : k == 0 ? 2 : 1);
            rows.row(row) = normals[k].transpose();
            // The body's lowest point along the normal, by a half-space.
            const HalfSpace half{normals[k], 0};
            level[row] = -solver.solve(Shape(half), Pose{}, body, pose, Request::distance).signed_distance - sunk;
          }
          pose.translation = rows.inverse() * level;
          // All walls are equally deep: the shortest translation is along the sum of the normals.
          Vec3 out = Vec3::Zero();
          for (const Vec3& normal : normals) out += normal;
          out *= sunk / normals[0].dot(out);
          const PairAnswer d = solver.solve(shape, Pose{}, body, pose, Request::distance);
          CHECK(d.status == Status::ok);
          CHECK(d.signed_distance == Approx(-out.norm()).epsilon(0).margin(1e-12));
          CHECK((d.normal - out.normalized()).norm() < 1e-6);
          for (const double far : {0.99, 1.01}) {
            const Pose there{pose.rotation, pose.translation - far * d.signed_distance * d.normal};
            CHECK(solver.solve(shape, Pose{}, body, there, Request::collide).collide == (far < 1));
          }
        }
    }
}

TEST_CASE("hunted: closed surfaces meet meshes of several parts as what they bound") {
  // A floor, and an overhanging wall.
  Mesh room{{{-1, -3, 0}, {5, -3, 0}, {5, 3, 0}, {-1, 3, 0}, {0, -3, 0.1}, {0, 3, 0.1}, {0, 3, 4}, {0, -3, 4}},
            {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}}};
  const NarrowPhase solver;
  const Vec3 size(1, 0.8, 0.6);
  Random r(9);
  for (int i = 0; i < 20; ++i) {
    Mesh box = box_mesh(size, 1 + i % 2);
    box.solid = false;
    const double down = r.power_of_two(-20, -7), aside = r.power_of_two(-20, -7);
    const Pose at = Pose::at(size.x() / 2 - aside, r.unit(), size.z() / 2 - down);
    CAPTURE(i, down, aside);
    const PairAnswer d = solver.solve(Shape(room), Pose{}, Shape(box), at, Request::distance);
    CHECK(d.status == Status::ok);
    CHECK(d.signed_distance == Approx(-std::hypot(down, aside)).epsilon(0).margin(1e-12));
    std::vector<Contact> contacts;
    solver.solve(Shape(room), Pose{}, Shape(box), at, Request::contacts, &contacts);
    CHECK(contacts.size() == 8);
    for (const Contact& c : contacts) {
      const bool is_floor = c.normal.z() > 0.5;
      CHECK((c.normal - (is_floor ? Vec3::UnitZ() : Vec3::UnitX())).norm() < 1e-12);
      CHECK(c.depth == Approx(is_floor ? down : aside).epsilon(0).margin(1e-12));
    }
  }
}

TEST_CASE("hunted: what has come into a corner of a solid is pushed by each of its walls") {
  // The solid below z = 0 and behind x = 0.
  const Mesh room = prism({{0, 0, 0}, {0, 0, 4}, {-1, 0, 4}, {-1, 0, -1}, {4, 0, -1}, {4, 0, 0}},
                          {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, 6);
  // An L standing on its foot with its back to the wall.
  const Mesh foot = prism({{0, 0, 0}, {1, 0, 0}, {1, 0, 0.3}, {0.3, 0, 0.3}, {0.3, 0, 1}, {0, 0, 1}},
                          {{0, 1, 3}, {1, 2, 3}, {0, 3, 5}, {3, 4, 5}}, 0.8);
  const Mesh cube = box_mesh(Vec3(1, 1, 1), 2);
  Mesh hollow = cube;
  hollow.solid = false;
  const NarrowPhase solver;
  Random r(17);
  for (int i = 0; i < 240; ++i) {
    const double down = r.power_of_two(-18, -7), aside = r.power_of_two(-18, -7);
    const Mat3 turned = i % 2 == 0 ? Mat3(Mat3::Identity()) : r.rotation();
    const bool is_cube = i % 3 != 0;
    const Vec3 at(is_cube ? 0.5 : 0, r.unit(), is_cube ? 0.5 : 0);
    const Pose pose{turned, turned * (at - Vec3(aside, 0, down))};
    CAPTURE(i, down, aside);
    std::vector<Contact> contacts;
    solver.solve(Shape(room), Pose{turned, Vec3::Zero()}, i % 3 == 0 ? Shape(foot) : Shape(i % 3 == 1 ? cube : hollow),
                 pose, Request::contacts, &contacts);
    int on_floor = 0, on_wall = 0;
    for (const Contact& c : contacts) {
      const Vec3 normal = turned.transpose() * c.normal, p = turned.transpose() * c.point;
      const bool is_floor = normal.z() > 0.5;
      (is_floor ? on_floor : on_wall) += 1;
      CHECK((normal - (is_floor ? Vec3::UnitZ() : Vec3::UnitX())).norm() < 1e-9);
      CHECK(c.depth == Approx(is_floor ? down : aside).epsilon(0).margin(1e-12));
      CHECK((is_floor ? p.z() : p.x()) == Approx(is_floor ? -down / 2 : -aside / 2).epsilon(0).margin(1e-9));
    }
    CHECK(on_floor == 4);
    CHECK(on_wall == 4);
  }
}

TEST_CASE("hunted: meshes whose flat faces have sunk into each other are pushed by each of these faces") {
  const std::vector<std::array<std::uint32_t, 3>> cap{{0, 1, 4}, {1, 2, 3}, {1, 3, 4}, {0, 4, 5}};
  // A step at x = 0, and one that hangs over it, with both its treads and its riser on the other's.
  Mesh stairs = prism({{-4, 0, -2}, {4, 0, -2}, {4, 0, 1}, {0, 0, 1}, {0, 0, 0}, {-4, 0, 0}}, cap, 8);
  Mesh above = prism({{2.5, 0, 2}, {-2.5, 0, 2}, {-2.5, 0, -1}, {0, 0, -1}, {0, 0, 0}, {2.5, 0, 0}}, cap, 3);
  const NarrowPhase solver;
  Random r(29);
  for (int i = 0; i < 120; ++i) {
    const double down = r.power_of_two(-20, -7), aside = r.power_of_two(-20, -7);
    const bool free = i % 4 == 3;  // of the riser
    const Mat3 turned = i % 2 == 0 ? Mat3(Mat3::Identity()) : r.rotation();
    const Vec3 at(free ? -0.3 : aside, r.unit(), 1 - down);
    stairs.solid = i % 3 != 0, above.solid = i % 5 != 0;
    CAPTURE(i, down, aside);
    const auto contacts_at = [&](const Pose& pose) {
      std::vector<Contact> contacts;
      solver.solve(Shape(stairs), Pose{turned, Vec3::Zero()}, Shape(above), pose, Request::contacts, &contacts);
      return contacts;
    };
    const std::vector<Contact> contacts = contacts_at({turned, turned * at});
    int on_treads = 0, on_riser = 0;
    double low = 1, high = -1;
    for (const Contact& c : contacts) {
      const Vec3 normal = turned.transpose() * c.normal, p = turned.transpose() * c.point;
      const bool is_tread = normal.z() > 0.5;
      (is_tread ? on_treads : on_riser) += 1;
      CHECK((normal - (is_tread ? Vec3::UnitZ() : Vec3(-Vec3::UnitX()))).norm() < 1e-9);
      CHECK(c.depth == Approx(is_tread ? down : aside).epsilon(0).margin(1e-12));
      if (!is_tread) CHECK(p.x() == Approx(aside / 2).epsilon(0).margin(1e-9));
      if (is_tread) CHECK(p.z() == Approx((p.x() > 0 ? 1 : 0) - down / 2).epsilon(0).margin(1e-9));
      low = std::min(low, p.x()), high = std::max(high, p.x());
    }
    CHECK(on_treads == 4);
    CHECK(on_riser == (free ? 0 : 4));
    CHECK(high - low > 4.9);
    const Mat3 nudged = Eigen::AngleAxisd(1e-9, r.rotation().col(0)).toRotationMatrix() * turned;
    const std::vector<Contact> again = contacts_at({nudged, turned * at + 1e-9 * r.rotation().col(0)});
    for (const Contact& c : contacts)
      CHECK(std::any_of(again.begin(), again.end(), [&](const Contact& o) {
        return (o.point - c.point).norm() < 1e-6 && (o.normal - c.normal).norm() < 1e-6;
      }));
  }
}

TEST_CASE("hunted: concave meshes leave each other by the shortest way past all the faces that hold them") {
  const std::vector<std::array<std::uint32_t, 3>> step{{0, 1, 4}, {1, 2, 3}, {1, 3, 4}, {0, 4, 5}};
  Mesh stairs = prism({{-4, 0, -2}, {4, 0, -2}, {4, 0, 1}, {0, 0, 1}, {0, 0, 0}, {-4, 0, 0}}, step, 8);
  Mesh above = prism({{2.5, 0, 2}, {-2.5, 0, 2}, {-2.5, 0, -1}, {0, 0, -1}, {0, 0, 0}, {2.5, 0, 0}}, step, 3);
  const std::vector<std::array<std::uint32_t, 3>> gap{{0, 4, 5}, {0, 1, 4}, {1, 3, 4}, {1, 2, 3}, {0, 5, 7}, {5, 6, 7}};
  Mesh slot =
      prism({{-3, 0, -2}, {3, 0, -2}, {3, 0, 1}, {1, 0, 1}, {1, 0, 0}, {-1, 0, 0}, {-1, 0, 1}, {-3, 0, 1}}, gap, 8);
  const std::vector<std::array<std::uint32_t, 3>> tee{{0, 1, 2}, {0, 2, 7}, {2, 3, 4}, {2, 4, 5}, {2, 5, 7}, {5, 6, 7}};
  Mesh peg = prism(
      {{-0.7, 0, 0.3}, {0.7, 0, 0.3}, {0.7, 0, 1}, {2, 0, 1}, {2, 0, 1.5}, {-2, 0, 1.5}, {-2, 0, 1}, {-0.7, 0, 1}}, tee,
      3);
  const NarrowPhase solver;
  Random r(37);
  for (int i = 0; i < 160; ++i) {
    const double down = r.power_of_two(-20, -7), aside = r.power_of_two(-20, -7);
    const bool is_peg = i % 2 == 1;
    const Mat3 turned = i % 4 < 2 ? Mat3(Mat3::Identity()) : r.rotation();
    const Vec3 at = is_peg ? Vec3(0.3 + aside, r.unit(), -down) : Vec3(aside, r.unit(), 1 - down);
    for (Mesh* m : {&stairs, &above, &slot, &peg}) m->solid = r.once_in(2);
    const Shape a(is_peg ? slot : stairs), b(is_peg ? peg : above);
    CAPTURE(i, down, aside);
    const PairAnswer overlap =
        solver.solve(a, Pose{turned, Vec3::Zero()}, b, Pose{turned, turned * at}, Request::distance);
    CHECK(overlap.status == Status::ok);
    CHECK(overlap.signed_distance == Approx(-std::hypot(down, aside)).epsilon(0).margin(1e-11));
    CHECK((turned.transpose() * overlap.normal - Vec3(-aside, 0, down).normalized()).norm() < 1e-6);
  }
}

// A bar that is in a wall and, at its side, in a block, with a post that hangs through a shelf. A translation off the
// shelf is longer than one past its end, where the post is free.
TEST_CASE("hunted: a face holds a mesh only as far as to its border") {
  const std::vector<std::array<std::uint32_t, 3>> tee{{0, 1, 2}, {0, 2, 5}, {0, 5, 6}, {0, 6, 7}, {2, 3, 4}, {2, 4, 5}};
  Mesh fixed =
      prism({{-8, 0, -20}, {0, 0, -20}, {0, 0, -0.1}, {5.2, 0, -0.1}, {5.2, 0, 0}, {0, 0, 0}, {0, 0, 20}, {-8, 0, 20}},
            tee, 8);
  const Mesh block = prism({{6, 0, -1}, {9, 0, -1}, {9, 0, 6}, {6, 0, 6}}, {{0, 1, 2}, {0, 2, 3}}, 4.8);
  const auto first = static_cast<std::uint32_t>(fixed.vertices.size());
  for (const Vec3& v : block.vertices) fixed.vertices.push_back(v - Vec3(0, 3.6, 0));
  for (const auto& t : block.triangles) fixed.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  Mesh bar = prism({{3, 0, -1.9},
                    {3.1, 0, -1.9},
                    {3.1, 0, 2.4},
                    {10, 0, 2.4},
                    {10, 0, 2.5},
                    {-2.2, 0, 2.5},
                    {-2.2, 0, 2.4},
                    {3, 0, 2.4}},
                   {{0, 1, 2}, {0, 2, 7}, {5, 6, 7}, {5, 7, 2}, {5, 2, 3}, {5, 3, 4}}, 3);
  fixed.solid = bar.solid = true;
  const PairAnswer overlap = NarrowPhase().solve(Shape(fixed), Pose{}, Shape(bar), Pose{}, Request::distance);
  CAPTURE(overlap.signed_distance, overlap.error_bound, overlap.status, overlap.normal.transpose());
  const double shortest = std::hypot(2.2, 0.3);
  CHECK(-overlap.signed_distance > shortest - 1e-9);
  CHECK(-overlap.signed_distance - overlap.error_bound < shortest + 1e-9);
}

// Beside a triangle that fits between two faces of the other mesh there is a gap only as wide as rounding.
TEST_CASE("hunted: no translation out of a mesh ends in a gap as wide as rounding") {
  const Mesh angle = prism({{0, 0, 0}, {2, 0, 0}, {2, 0, 0.5}, {0.5, 0, 0.5}, {0.5, 0, 2}, {0, 0, 2}},
                           {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, 1);
  const Mesh fork =
      prism({{0, 0, 0}, {2, 0, 0}, {2, 0, 2}, {1.1, 0, 2}, {1.1, 0, 0.8}, {0.9, 0, 0.8}, {0.9, 0, 2}, {0, 0, 2}},
            {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}}, 1.4);
  const Mesh in_angle{{Vec3(1.8, -0.6, 0.3), Vec3(2.9, -0.2, 2.8), Vec3(0.3, 0.7, 2)}, {{0, 1, 2}}};
  const Mesh in_fork{{Vec3(2.2, 2.1, 2), Vec3(2.4, 2.1, -0.4), Vec3(0.5, -0.6, 3)}, {{0, 1, 2}}};
  const NarrowPhase solver;
  for (const auto& [solid, sheet] : {std::pair(&angle, &in_angle), std::pair(&fork, &in_fork)}) {
    const Shape a(*solid), b(*sheet);
    const PairAnswer overlap = solver.solve(a, Pose{}, b, Pose{}, Request::distance);
    REQUIRE(overlap.collide);
    // It may end at the other side of a notch: then it is free a little to one side.
    bool is_free_nearby = false;
    for (int k = 0; k < 27; ++k) {
      const Vec3 aside(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
      const Pose moved{Mat3::Identity(), 1e-10 * aside - overlap.signed_distance * overlap.normal};
      is_free_nearby = is_free_nearby || !solver.solve(a, Pose{}, b, moved, Request::collide).collide;
    }
    CHECK(is_free_nearby);
  }
}

TEST_CASE("hunted: a box that touches both sides of a notch is not pushed from the one into the other") {
  const Shape notch(prism({{-1, 0, -0.5}, {1, 0, -0.5}, {1, 0, 1}, {0.5, 0, 1}, {0, 0, 0}, {-0.5, 0, 1}, {-1, 0, 1}},
                          {{0, 1, 4}, {1, 2, 3}, {1, 3, 4}, {0, 4, 5}, {0, 5, 6}}, 1));
  Mesh surface = box_mesh({0.5, 0.4, 0.5});
  surface.solid = false;
  const Shape box(surface);
  const NarrowPhase solver;
  Random r(43);
  int touching = 0;
  for (int i = 0; i < 100; ++i) {
    const Mat3 turned = r.rotation();
    const auto solve = [&](const Vec3& move, Request request) {
      return solver.solve(notch, Pose{turned, Vec3::Zero()}, box, Pose{turned, turned * Vec3(0, 0, 0.75) + move},
                          request);
    };
    const PairAnswer overlap = solve(Vec3::Zero(), Request::distance);
    if (!overlap.collide) continue;
    ++touching;
    CAPTURE(i, overlap.signed_distance, overlap.error_bound);
    CHECK(overlap.signed_distance > -1e-11);
    CHECK_FALSE(solve((1e-11 - overlap.signed_distance) * overlap.normal, Request::collide).collide);
  }
  CHECK(touching > 50);
}

TEST_CASE("hunted: what reaches little out of a closed surface that has no inside may part from it by going in") {
  Mesh surface = torus(1, 0.4, 10, 7);
  surface.solid = false;
  const Shape a(surface);
  const NarrowPhase solver;
  Random r(53);
  for (int i = 0; i < 600; ++i) {
    const Shape b(Triangle{{0.3 * r.direction(), 0.3 * r.direction(), 0.3 * r.direction()}});
    const Pose at{r.rotation(), r.vec_of_length(0.6, 1.4).cwiseProduct(Vec3(1, 1, 0.3))};
    const PairAnswer overlap = solver.solve(a, Pose{}, b, at, Request::distance);
    if (!overlap.collide || overlap.status != Status::ok || overlap.signed_distance > -1e-6) continue;
    CAPTURE(i, overlap.signed_distance);
    const Pose moved{at.rotation, at.translation - 0.99 * overlap.signed_distance * overlap.normal};
    CHECK(solver.solve(a, Pose{}, b, moved, Request::collide).collide);
  }
}

TEST_CASE("hunted: moving by the deepest contact of a speck in a capsule separates them to rounding") {
  // Two triangles, equally deep to 4e-12, each along its own normal.
  const Shape speck(Mesh{{Vec3(-2e-5, -2e-5, -2e-5), Vec3(5e-5, 5e-5, -5e-5), Vec3(3.8147e-5, -7.6294e-6, 2.2888e-5),
                          Vec3(7.6294e-6, 4.5776e-5, 3.8147e-5), Vec3(-2e-5, -5e-5, -6e-5), Vec3(0, -3e-5, -4e-5)},
                         {{0, 1, 2}, {3, 4, 5}}});
  const Shape capsule(Capsule{0.625, 1});
  const Pose lying{(Mat3() << 0, 1, 0, 0, 0, -1, -1, 0, 0).finished(), Vec3::Zero()};
  const Pose inside{Vec3(-1, 1, -1).asDiagonal().toDenseMatrix(), Vec3(0.125, -0.125, 0.25)};
  const NarrowPhase solver;
  std::vector<Contact> contacts;
  const PairAnswer deepest = solver.solve(capsule, lying, speck, inside, Request::contacts, &contacts);
  CAPTURE(deepest.signed_distance, deepest.error_bound);
  CHECK(deepest.error_bound < 1e-9);
  const Pose moved{inside.rotation, inside.translation + (3e-12 - deepest.signed_distance) * deepest.normal};
  CHECK((deepest.status == Status::inexact || !solver.solve(capsule, lying, speck, moved, Request::collide).collide));
}

TEST_CASE("hunted: a mesh is not deeper in another than a way that was tried is long") {
  const Shape plate(box_mesh(2 * Vec3(0.24925613403320312, 0.524531364440918, 0.0035533905029296875)));
  // A sliver: rounding makes its depth 9e-10 where the two only touch.
  const Shape sliver(Mesh{{Vec3(-0.886566162109375, 0.142669677734375, 0.9890155792236328),
                           Vec3(-0.3022146224975586, 0.8825368881225586, -0.5485916137695312),
                           Vec3(-0.5871571335962865, 0.5217615552908241, 0.20117907271467153)},
                          {{0, 1, 2}}});
  const Pose at_plate{
      (Mat3() << 0.13875248103751914, 0.9891261614888054, -0.04875639101035345, -0.3261128509264408,
       -0.0008511902199919152, -0.945330462820192, -0.9350925929909625, 0.14706703278991845, 0.3224486476941828)
          .finished(),
      Vec3::Zero()};
  const Pose at_sliver{
      (Mat3() << -0.7926608250935516, -0.6069725504872097, -0.05721135653925863, 0.025623267894378243,
       -0.12692545826723078, 0.9915812504207947, -0.6091241782300416, 0.7845216701906362, 0.1161614587411478)
          .finished(),
      Vec3(0.6232653943288613, 0.4969871872434304, -0.4943769528285826)};
  const PairAnswer overlap = NarrowPhase().solve(plate, at_plate, sliver, at_sliver, Request::distance);
  CHECK(overlap.collide);
  CHECK(overlap.signed_distance > -1e-11);
}

TEST_CASE("hunted: contacts of concave meshes whose faces have sunk into each other are the same at any scale") {
  const auto angle = [](double width) {
    return prism({{0, 0, 0}, {2, 0, 0}, {2, 0, 0.5}, {0.5, 0, 0.5}, {0.5, 0, 2}, {0, 0, 2}},
                 {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, width);
  };
  const auto solve = [&](double factor, const Vec3& move) {
    Mesh narrow = angle(1), wide = angle(1.25);
    for (Mesh* m : {&narrow, &wide})
      for (Vec3& v : m->vertices) v *= factor;
    std::vector<Contact> contacts;
    const Pose at{Mat3::Identity(), factor * move};
    NarrowPhase().solve(Shape(narrow), Pose{}, Shape(wide), at, Request::contacts, &contacts);
    return contacts;
  };
  for (const Vec3& move : {Vec3(0.5, -0.5, -0.375), Vec3(0.375, -0.125, -0.25), Vec3(-0.125, -0.25, 0.125)}) {
    const std::vector<Contact> expected = solve(1, move);
    for (const int power : {-80, -28, -20, 30, 80}) {
      const double factor = std::ldexp(1.0, power);
      const std::vector<Contact> contacts = solve(factor, move);
      CAPTURE(move.transpose(), power);
      REQUIRE(contacts.size() == expected.size());
      for (std::size_t i = 0; i < contacts.size(); ++i) {
        CHECK(contacts[i].depth == factor * expected[i].depth);
        CHECK(contacts[i].point == factor * expected[i].point);
      }
    }
  }
}

TEST_CASE("hunted: the depth and the deepest contact of two meshes agree to rounding where both are certain") {
  const Shape tube(torus(1, 0.4, 12, 7));
  Mesh surface = box_mesh({1, 1, 1});
  surface.solid = false;
  const Shape cube(surface);
  const Shape angle(prism({{0, 0, 0}, {2, 0, 0}, {2, 0, 1}, {1, 0, 1}, {1, 0, 2}, {0, 0, 2}},
                          {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, 1));
  const NarrowPhase solver;
  Random r(47);
  int certain = 0;
  for (int i = 0; i < 120; ++i) {
    const bool is_tube = i % 2 == 0;
    const Shape &a = is_tube ? tube : cube, &b = is_tube ? tube : angle;
    // Tubes that have sunk into each other by 1e-11, a surface of a cube that lies nearly flush in an angle.
    Pose at{is_tube ? r.rotation() : Mat3(Eigen::AngleAxisd(1e-11, r.direction())),
            is_tube ? Vec3(1.5 * r.direction()) : Vec3::Zero()};
    for (int step = 0; is_tube && step < 2; ++step) {
      const PairAnswer d = solver.solve(a, Pose{}, b, at, Request::distance);
      at.translation -= (d.signed_distance + 1e-11) * d.normal;
    }
    std::vector<Contact> contacts;
    const PairAnswer overlap = solver.solve(a, Pose{}, b, at, Request::distance);
    const PairAnswer deepest = solver.solve(a, Pose{}, b, at, Request::contacts, &contacts);
    if (overlap.status != Status::ok || deepest.status != Status::ok) continue;
    ++certain;
    CAPTURE(i, overlap.signed_distance, deepest.signed_distance);
    CHECK(std::abs(overlap.signed_distance - deepest.signed_distance) < 4e-12);
  }
  CHECK(certain > 30);
}

TEST_CASE("hunted: the bound of a depth that is not certain comes from a way that nothing near it is shorter than") {
  // Stars whose points are in each other's gaps, along one axis.
  const Shape a(star(0.4)), b(star(0.5));
  const NarrowPhase solver;
  Random r(41);
  int known = 0, tight = 0;
  constexpr int n = 40;
  for (int i = 0; i < n; ++i) {
    const Mat3 turned = r.rotation();
    const Mat3 half = Eigen::AngleAxisd(full_turn / 2 + r.in(-0.1, 0.1), Vec3::UnitY()).toRotationMatrix();
    const Vec3 at{1.62 - r.in(0, 0.05), r.in(-0.02, 0.02), r.in(-0.05, 0.05)};
    const auto solve = [&](const Vec3& move, Request request) {
      return solver.solve(a, Pose{turned, Vec3::Zero()}, b, Pose{turned * half, turned * at + move}, request);
    };
    const PairAnswer overlap = solve(Vec3::Zero(), Request::distance);
    CAPTURE(i, overlap.signed_distance, overlap.error_bound);
    if (!overlap.collide) continue;
    known += overlap.status == Status::ok;
    tight += overlap.error_bound < 0.25 * -overlap.signed_distance;
    CHECK_FALSE(solve((1e-11 - overlap.signed_distance) * overlap.normal, Request::collide).collide);
  }
  CHECK(known >= 8);
  CHECK(tight >= 36);  // of 4,000 such pairs 3,839; the distances of the others are right, their bounds up to 0.29
}

TEST_CASE(
    "hunted: round bodies in each other keep their contacts, moved by 1e-9 or together, their triangles shuffled") {
  // Bowls: an arc revolved about z, as thick as the width of its edge; one lies in the other, shifted along z or
  // slightly sideways.
  const auto bowl = [](std::uint32_t around) {
    Mesh m;
    m.solid = true;
    std::vector<std::array<double, 2>> profile{{0, -1}};
    for (const double radius : {1.0, 0.85}) {
      for (int i = 0; i < 5; ++i) {
        const double angle = 0.3 + 0.3 * (radius == 1.0 ? i : 4 - i);
        profile.push_back({radius * std::sin(angle), -radius * std::cos(angle)});
      }
    }
    profile.push_back({0, -0.85});
    std::vector<std::uint32_t> rows;
    for (const auto& [out, up] : profile) {
      rows.push_back(static_cast<std::uint32_t>(m.vertices.size()));
      for (std::uint32_t i = 0; i < (out == 0 ? 1 : around); ++i)
        m.vertices.emplace_back(out * std::cos(full_turn * i / around), out * std::sin(full_turn * i / around), up);
    }
    const std::size_t last = profile.size() - 1;
    for (std::uint32_t i = 0; i < around; ++i) {
      const std::uint32_t next = (i + 1) % around;
      m.triangles.push_back({rows[0], rows[1] + next, rows[1] + i});
      m.triangles.push_back({rows[last], rows[last - 1] + i, rows[last - 1] + next});
      for (std::size_t k = 1; k + 1 < last; ++k) {
        m.triangles.push_back({rows[k] + i, rows[k] + next, rows[k + 1] + next});
        m.triangles.push_back({rows[k] + i, rows[k + 1] + next, rows[k + 1] + i});
      }
    }
    return m;
  };
  // As in a step: replacements of contacts that are too deep are found by a search, possibly elsewhere.
  const NarrowPhase solver({.mesh_bounds = false});
  Random r(43);
  for (int i = 0; i < 96; ++i) {
    const bool are_stars = i % 4 == 3;
    Mesh mesh = are_stars ? star(0.4) : bowl(i % 2 == 0 ? 8 : 16), other = are_stars ? star(0.55) : mesh;
    mesh.solid = i % 5 != 0, other.solid = i % 7 != 0;
    Mesh shuffled = mesh;
    std::reverse(shuffled.triangles.begin(), shuffled.triangles.end());
    const double angle = are_stars ? full_turn / 2 + r.in(-0.1, 0.1) : full_turn / 32 * (i % 5);
    const Vec3 at = are_stars ? Vec3(1.62 - r.in(0, 0.05), 0.02, 0)
                              : Vec3(i % 3 == 0 ? 0.02 : 0, 0, 0.15 * (i % 8 < 4 ? 1.003 : 0.98));
    const Mat3 own = Eigen::AngleAxisd(angle, are_stars ? Vec3::UnitY() : Vec3::UnitZ()).toRotationMatrix();
    const auto contacts_at = [&](const Mesh& of_a, const Mat3& turned, const Vec3& moved, const Mat3& nudged,
                                 double far) {
      std::vector<Contact> contacts;
      solver.solve(Shape(of_a), Pose{turned, moved}, Shape(other),
                   {turned * nudged * own, turned * (at + far * r.direction()) + moved}, Request::contacts, &contacts);
      for (Contact& c : contacts)
        c = {turned.transpose() * (c.point - moved), turned.transpose() * c.normal, c.depth, 0};
      return contacts;
    };
    const Mat3 as_it_is = Mat3::Identity();
    const std::vector<Contact> contacts = contacts_at(mesh, as_it_is, Vec3::Zero(), as_it_is, 0);
    CAPTURE(i, contacts.size());
    REQUIRE_FALSE(contacts.empty());
    const auto check = [&](const std::vector<Contact>& again) {
      CHECK(again.size() == contacts.size());
      for (const Contact& c : contacts)
        CHECK(std::any_of(again.begin(), again.end(), [&](const Contact& o) {
          return (o.point - c.point).norm() < 1e-6 && (o.normal - c.normal).norm() < 1e-6 &&
                 std::abs(o.depth - c.depth) < 1e-6;
        }));
    };
    check(contacts_at(mesh, as_it_is, Vec3::Zero(), Eigen::AngleAxisd(1e-9, r.direction()).toRotationMatrix(), 1e-9));
    check(contacts_at(mesh, r.rotation(), r.vec(-5, 5), as_it_is, 0));
    // Where many edges of both meshes cross each other, only the first are examined.
    if (are_stars || i % 3 != 0) check(contacts_at(shuffled, as_it_is, Vec3::Zero(), as_it_is, 0));
  }
}

TEST_CASE("hunted: an edge of a solid that has come through a face of another is pushed along the face's normal") {
  const Mesh stairs = prism({{-4, 0, -2}, {4, 0, -2}, {4, 0, 1}, {0, 0, 1}, {0, 0, 0}, {-4, 0, 0}},
                            {{0, 1, 4}, {1, 2, 3}, {1, 3, 4}, {0, 4, 5}}, 8);
  // A hexagonal foot.
  std::vector<Vec3> foot;
  for (int i = 0; i < 6; ++i)
    foot.emplace_back(0.5 * std::cos(0.2 + full_turn * i / 6), 0, 0.5 * std::sin(0.2 + full_turn * i / 6));
  Mesh body = prism(foot, {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}, 1);
  const NarrowPhase solver;
  Random r(31);
  for (int i = 0; i < 60; ++i) {
    const bool at_end = i % 3 == 1;  // of the edge
    const double angle = (i % 12 + 1) * full_turn / 72, sunk = r.power_of_two(-16, -7);
    const Mat3 turned = i % 2 == 0 ? Mat3(Mat3::Identity()) : r.rotation();
    const Mat3 leaning =
        (Eigen::AngleAxisd(-angle, Vec3::UnitY()) * Eigen::AngleAxisd(full_turn / 4, Vec3::UnitX())).matrix();
    const Vec3 normal = leaning.col(1), at = Vec3(0, at_end ? 3.9 : r.unit(), 1) + (0.5 - sunk) * normal;
    body.solid = i % 3 == 0;
    CAPTURE(i, angle, sunk);
    std::vector<Contact> contacts;
    solver.solve(Shape(stairs), Pose{turned, Vec3::Zero()}, Shape(body), {turned * leaning, turned * at},
                 Request::contacts, &contacts);
    REQUIRE(contacts.size() == 2);
    CHECK((contacts[0].point - contacts[1].point).norm() > (at_end ? 0.5 : 0.85));
    for (const Contact& c : contacts) {
      CHECK((turned.transpose() * c.normal - normal).norm() < 1e-9);
      CHECK(c.depth == Approx(sunk).epsilon(0).margin(1e-12));
    }
  }
}

TEST_CASE("hunted: a triangle that lies on a floor has one patch, whichever side rounding puts it on") {
  const NarrowPhase solver;
  const Shape triangle(Triangle{{Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0)}});
  const Shape floor(Mesh{{{-3, -3, 0}, {3, -3, 0}, {3, 3, 0}, {-3, 3, 0}}, {{0, 1, 2}, {0, 2, 3}}});
  Random r(23);
  int touching = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose ground{i % 2 == 0 ? Mat3(Mat3::Identity()) : r.rotation(), Vec3{r.unit(), r.unit(), r.unit()}};
    const Mat3 spun = Eigen::AngleAxisd(full_turn * r.unit(), Vec3::UnitZ()).toRotationMatrix();
    const Pose at{ground.rotation * spun, ground * Vec3{r.unit(), r.unit(), 0}};
    std::vector<Contact> contacts;
    solver.solve(floor, ground, triangle, at, Request::contacts, &contacts);
    touching += contacts.empty() ? 0 : 1;
    CAPTURE(i);
    CHECK(contacts.size() <= 4);
    for (const Contact& c : contacts) {
      CHECK(std::abs(c.normal.dot(ground.rotation.col(2))) == Approx(1).margin(1e-9));
      CHECK(c.normal.dot(contacts[0].normal) > 0.9);
      CHECK(std::abs(c.depth) < 1e-12);
    }
  }
  CHECK(touching > 100);
}

TEST_CASE("hunted: two convex solids that lie flush touch where both are, wherever their frames have their origins") {
  const NarrowPhase solver;
  Random r(29);
  int touching = 0;
  for (int i = 0; i < 300; ++i) {
    Vec3 size_a, size_b, at;
    for (Vec3* v : {&size_a, &size_b, &at})
      for (double& x : *v) x = 0.1 * (v == &at ? r.below(2) : 2 + r.below(4));
    at[0] = size_a[0];
    // A has its origin in the middle of B.
    const Vec3 origin = at + size_b / 2;
    Mesh a = box_mesh(size_a), b = box_mesh(size_b);
    for (Vec3& v : a.vertices) v += size_a / 2 - origin;
    for (Vec3& v : b.vertices) v += size_b / 2;
    a.solid = b.solid = true;
    const Pose turned{r.rotation(), r.vec(-5, 5)};
    std::vector<Contact> contacts;
    solver.solve(Shape(a), {turned.rotation, turned * origin}, Shape(b), {turned.rotation, turned * at},
                 Request::contacts, &contacts);
    touching += contacts.empty() ? 0 : 1;
    CAPTURE(i);
    for (const Contact& c : contacts) {
      const Vec3 place = turned.rotation.transpose() * (c.point - turned.translation);
      CHECK(std::abs(c.depth) < 1e-12);
      CHECK((at.cwiseMax(Vec3::Zero()) - place).maxCoeff() < 1e-9);
      CHECK((place - size_a.cwiseMin(at + size_b)).maxCoeff() < 1e-9);
    }
  }
  CHECK(touching > 50);
}
