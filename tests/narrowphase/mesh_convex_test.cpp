// A mesh and a convex shape: verdicts, distances, contacts.
#include <cmath>
#include <limits>
#include <numbers>

#include "ask.h"
#include "catch.h"
#include "mesh_samples.h"
#include "meshes/traversal/point_in_mesh.h"
#include "random_pairs.h"
#include "shapes/mesh_builder.h"
#include "shapes/shape_insides.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/shape_makers.h"

using namespace tandem;
using namespace tandem::test;

namespace {

PairAnswer answer(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb) {
  return NarrowPhase().solve(a, pa, b, pb, Request::distance);
}

bool is_round(ShapeKind k) { return k == ShapeKind::cylinder || k == ShapeKind::cone || k == ShapeKind::ellipsoid; }

std::vector<Shape> convex_shapes() {
  return {Sphere{0.2},
          Box{Vec3(0.3, 0.4, 0.5)},
          Capsule{0.15, 0.4},
          Cylinder{0.2, 0.4},
          Cone{0.2, 0.5},
          Ellipsoid{Vec3(0.1, 0.2, 0.3)},
          Shape(Convex{
              {Vec3(0.2, 0, 0), Vec3(-0.1, 0.2, 0), Vec3(-0.1, -0.2, 0.1), Vec3(0, 0, 0.3), Vec3(0.1, 0.1, -0.2)}}),
          Shape(Convex{{Vec3(0.2, 0, 0), Vec3(-0.1, 0.2, 0), Vec3(-0.1, -0.2, 0)}}),
          Triangle{{Vec3(0.2, 0, 0), Vec3(-0.1, 0.2, 0), Vec3(-0.1, -0.2, 0.1)}}};
}

// A level grid of n x n squares about the origin, facing up.
Mesh level_ground(double width, int n, bool flip = false) {
  Mesh mesh;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      mesh.vertices.emplace_back((i * 1.0 / n - 0.5) * width, (j * 1.0 / n - 0.5) * width, 0);
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const bool other = flip && (i + j) % 2 != 0;
      const auto a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      if (other) {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, c, d});
      } else {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      }
    }
  return mesh;
}

// A hollow box: the inner surface faces inward.
Mesh hollow_box(const Vec3& outer, const Vec3& inner) {
  Mesh mesh = box_mesh(outer, 2);
  const Mesh hole = box_mesh(inner, 2);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), hole.vertices.begin(), hole.vertices.end());
  for (const auto& t : hole.triangles) mesh.triangles.push_back({first + t[0], first + t[2], first + t[1]});
  return mesh;
}

// Verdict, distance and contacts of a pair.
struct MeshAnswers {
  bool collide;
  PairAnswer distance, contact;
  std::vector<Contact> contacts;
  double deepest = -std::numeric_limits<double>::infinity();
};

MeshAnswers answers(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, double margin = 0) {
  NarrowPhaseOptions options;
  options.margin = margin;
  const NarrowPhase solver(options);
  MeshAnswers r;
  r.collide = solver.solve(a, pa, b, pb, Request::collide).collide;
  r.distance = solver.solve(a, pa, b, pb, Request::distance);
  r.contact = solver.solve(a, pa, b, pb, Request::contacts, &r.contacts);
  for (const Contact& c : r.contacts) r.deepest = std::max(r.deepest, c.depth);
  return r;
}

Pose posed(const Vec3& t, const Mat3& rotation) { return {rotation, t}; }

Mat3 rows(const Vec3& x, const Vec3& y, const Vec3& z) {
  Mat3 m;
  m << x.transpose(), y.transpose(), z.transpose();
  return m;
}

// A prism with a U-shaped profile in the xy plane: a bar and two arms.
Mesh u_body(double half) {
  Mesh m;
  m.solid = true;
  for (const double z : {-half, half})
    for (const auto& [x, y] :
         {std::pair{0.0, 0.0}, {2.0, 0.0}, {2.0, 2.0}, {1.2, 2.0}, {1.2, 0.8}, {0.8, 0.8}, {0.8, 2.0}, {0.0, 2.0}})
      m.vertices.emplace_back(x, y, z);
  for (const auto& [i, j, k] :
       {std::array<std::uint32_t, 3>{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}, {0, 5, 6}, {0, 6, 7}}) {
    m.triangles.push_back({i, k, j});
    m.triangles.push_back({i + 8, j + 8, k + 8});
  }
  for (std::uint32_t i = 0; i < 8; ++i) {
    const std::uint32_t j = (i + 1) % 8;
    m.triangles.push_back({i, j, j + 8});
    m.triangles.push_back({i, j + 8, i + 8});
  }
  return m;
}

// Divides some edges by a degenerate triangle: the next triangle beside it keeps the whole edge.
Mesh with_flat_triangles(Mesh m, Random& r) {
  for (int i = 0; i < 6; ++i) {
    const auto t = static_cast<std::size_t>(r.below(static_cast<int>(m.triangles.size())));
    const auto [a, b, c] = m.triangles[t];
    const auto cut = static_cast<std::uint32_t>(m.vertices.size());
    m.vertices.push_back(m.vertices[a] + r.in(0.2, 0.8) * (m.vertices[b] - m.vertices[a]));
    m.triangles[t] = {a, cut, c};
    m.triangles.push_back({cut, b, c});
    m.triangles.push_back({a, b, cut});
  }
  return m;
}

// Some of the triangles of a torus or a U, as a surface.
Mesh open_shell(Random& r) {
  Mesh m = r.once_in(2) ? torus(1, r.in(0.2, 0.5), 6, 4) : u_body(r.in(0.2, 0.8));
  m.solid = false;
  const auto first = static_cast<std::ptrdiff_t>(r.in(0, static_cast<double>(m.triangles.size()) - 1));
  const auto count = static_cast<std::size_t>(r.in(1, static_cast<double>(m.triangles.size())));
  std::rotate(m.triangles.begin(), m.triangles.begin() + first, m.triangles.end());
  m.triangles.resize(count);
  return m;
}

}  // namespace

TEST_CASE("cubes that touch along edges are not their hull, though it has their area") {
  const std::vector<std::array<std::int32_t, 3>> dark{{0, 0, 0}, {2, 0, 0}, {1, 1, 0}, {0, 2, 0}, {2, 2, 0}};
  const Shape board = voxel_mesh(dark, 1);
  REQUIRE(!mesh_of(board).convex());
  const Sphere ball{0.25};
  CHECK(answer(board, {}, ball, Pose::at(1.5, 0.5, 0.5)).signed_distance == Approx(0.25));  // on a light one
  CHECK(answer(board, {}, ball, Pose::at(1.5, -1, 0.5)).signed_distance == Approx(std::hypot(0.5, 1) - 0.25));
}

TEST_CASE("the distance of a convex shape and a large mesh looks at few of its triangles") {
  const Shape ground(level_ground(60, 300));
  for (const Shape& shape : convex_shapes())
    for (const double height : {0.7, 20.0}) {
      CAPTURE(name(shape.kind()), height);
      int checks = 0;  // of the limit, one every few hundred triangles; all have some 600
      WorkLimit limit;
      limit.ended = [&] { return ++checks < 0; };
      NarrowPhaseOptions options;
      options.limit = &limit;
      const Pose pose = Pose::at(0.3, 0.2, height);
      const PairAnswer far = NarrowPhase(options).solve(ground, Pose{}, shape, pose, Request::distance);
      CHECK(far.signed_distance == Approx(pose.translation.z() + shape.bounds(Pose{}).lo.z()));
      CHECK(checks < 60);
    }
}

TEST_CASE("a surface keeps from a convex shape what its nearest triangle keeps, near and far") {
  Mesh ring = torus(1, 0.3, 12, 9);
  ring.solid = false;
  const Shape mesh(ring);
  Random r(31);
  for (const Shape& shape : convex_shapes())
    for (int i = 0; i < 24; ++i) {
      const Pose pa = random_pose(r, i % 3 == 0 ? 1e3 : 1);
      Pose pb = random_pose(r, 2);
      pb.translation += pa.translation;
      // Separated, then moved along the normal to a gap of 10^-1 .. 10^-13.
      PairAnswer d = answer(mesh, pa, shape, pb);
      if (d.signed_distance <= 0) continue;
      const double gap = std::pow(10, -1 - i % 13) * (i % 2 == 0 ? 1 : -1);
      if (i >= 8) pb.translation -= d.normal * (d.signed_distance - gap);
      d = answer(mesh, pa, shape, pb);
      double want = 1e9;
      for (std::uint32_t t = 0; t < ring.triangles.size(); ++t) {
        const Shape one(Triangle{mesh_of(mesh).corners(t)});
        want = std::min(want, answer(one, pa, shape, pb).signed_distance);
      }
      CAPTURE(name(shape.kind()), i, gap, want);
      const double off = (is_round(shape.kind()) ? 1e-10 : 1e-12) * (1 + pa.translation.norm() * 1e-3);
      if (want > 0) {
        CHECK(std::abs(d.signed_distance - want) <= off);
        const double apart = (d.point_b - d.point_a).dot(d.normal) - d.signed_distance;
        CHECK(std::abs(apart) <= 1e-10);
      } else {
        CHECK(d.signed_distance <= 1e-12);
        CHECK(-d.signed_distance >= -want - off);
      }
      CHECK(collide(mesh, pa, shape, pb) == (d.signed_distance <= 0));
      CHECK(d.collide == (d.signed_distance <= 0));
      const PairAnswer s = answer(shape, pb, mesh, pa);
      CHECK(s.signed_distance == d.signed_distance);
      CHECK(s.normal == -d.normal);
    }
}

TEST_CASE("contacts with a single triangle have the depth of that triangle, over its face and past its edges") {
  Random r(77);
  int deep = 0, apart = 0;
  for (const Shape& shape : convex_shapes()) {
    if (shape.kind() == ShapeKind::triangle) continue;  // two meshes: no distances are reported
    for (int i = 0; i < 300; ++i) {
      // From much larger than the shape to a third of it; the shape's centre slightly to far above it, or across.
      const double width = std::pow(10, r.in(-1, 0.7));
      const std::array<Vec3, 3> corners{width * Vec3(0.8, -0.5, 0), width * Vec3(0, 0.9, 0),
                                        width * Vec3(-0.8, -0.5, 0)};
      const Shape mesh(Mesh{{corners[0], corners[1], corners[2]}, {{0, 1, 2}}, false}), one(Triangle{corners});
      const Pose pa = random_pose(r, 1);
      Pose pb = random_pose(r, 1);
      const Vec3 over{width * r.in(-0.5, 0.5), width * r.in(-0.4, 0.4), 0};
      const Vec3 up = (i % 2 == 0 ? 1 : -1) * pa.rotation.col(2);
      pb.translation = pa * over + up;
      const PairAnswer far = answer(Shape(HalfSpace{up, up.dot(pa.translation)}), Pose{}, shape, pb);
      pb.translation -= (far.signed_distance + (i % 3 == 0 ? 0.3 : 0.03) * shape.size() * r.in(-0.2, 1)) * up;
      std::vector<Contact> contacts;
      const double margin = 0.02;
      const PairAnswer found = NarrowPhase({.tolerance = 0, .margin = margin, .solver = {}})
                                   .solve(mesh, pa, shape, pb, Request::contacts, &contacts);
      const PairAnswer truth = answer(one, pa, shape, pb);
      CAPTURE(name(shape.kind()), i, width, truth.signed_distance);
      if (truth.signed_distance > margin + 1e-9) {
        ++apart;
        CHECK(contacts.empty());
        CHECK_FALSE(found.collide);
        continue;
      }
      if (truth.signed_distance > margin - 1e-9) continue;
      REQUIRE_FALSE(contacts.empty());
      ++deep;
      CHECK(std::abs(found.signed_distance - truth.signed_distance) <= truth.error_bound + 1e-8);
      CHECK(found.collide == (found.signed_distance <= 0));
      // A translation by that length along the normal separates them.
      const PairAnswer off = answer(one, pa, shape, moved(pb, (2e-8 - found.signed_distance) * found.normal));
      CHECK(off.signed_distance > -1e-8);
    }
  }
  CHECK(deep > 1500);
  CHECK(apart > 100);
}

TEST_CASE("containment is exact: on faces, edges and corners, a bit outside, in cavities") {
  const MeshModel cube = build_mesh(box_mesh(Vec3(1, 1, 1), 4));
  const double out = std::nextafter(0.5, 1.0);
  for (const double x : {-0.5, -0.25, 0.0, 0.125, 0.5})
    for (const double y : {-0.5, -0.25, 0.0, 0.3, 0.5})
      for (const double z : {-0.5, -0.1, 0.0, 0.25, 0.5}) {
        const Vec3 p(x, y, z);
        CAPTURE(p.transpose());
        CHECK(is_inside(cube, p));
        for (int k = 0; k < 3; ++k)
          if (std::abs(p[k]) == 0.5) {
            Vec3 q = p;
            q[k] = std::copysign(out, p[k]);
            CHECK_FALSE(is_inside(cube, q));
            q[k] = std::copysign(std::nextafter(0.5, 0.0), p[k]);
            CHECK(is_inside(cube, q));
          }
      }
  const MeshModel hollow = build_mesh(hollow_box(Vec3(2, 2, 2), Vec3(1, 1, 1)));
  CHECK_FALSE(is_inside(hollow, Vec3(0, 0, 0)));
  CHECK_FALSE(is_inside(hollow, Vec3(0.5 - 1e-16, 0, 0)));
  CHECK(is_inside(hollow, Vec3(0.5, 0, 0)));
  CHECK(is_inside(hollow, Vec3(0.5, 0.5, 0.5)));
  CHECK(is_inside(hollow, Vec3(0.75, 0, 0)));
  CHECK_FALSE(is_inside(hollow, Vec3(1 + 1e-15, 0, 0)));

  // In a pose: a multiple of a power of two and a quarter turn are exact, and so is the answer.
  Pose turned;
  turned.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  turned.translation = Vec3(1 << 20, 0, -(1 << 20));
  Pose at = turned;
  at.translation.x() += 0.5;
  CHECK(is_inside(cube, turned, Vec3(0, 0, 0), at));
  CHECK(is_inside(cube, turned, Vec3(0, 0, 0.5), at));
  at.translation.x() = std::nextafter(at.translation.x(), 1e9);
  CHECK_FALSE(is_inside(cube, turned, Vec3(0, 0, 0), at));
  CHECK_FALSE(is_inside(cube, turned, Vec3(1e-300, -0x1p-52, 0), moved(turned, Vec3(0.5, 0, 0))));
  CHECK(is_inside(cube, turned, Vec3(1e-300, 0, 0), moved(turned, Vec3(0.5, 0, 0))));
}

TEST_CASE("a solid with a cavity: what floats in it touches nothing") {
  const Shape shell(hollow_box(Vec3(2, 2, 2), Vec3(1, 1, 1)));
  for (const Shape& s : convex_shapes()) {
    CAPTURE(name(s.kind()));
    CHECK_FALSE(collide(shell, Pose{}, s, Pose{}));
    CHECK(answer(shell, Pose{}, s, Pose{}).signed_distance > 0);
    CHECK(collide(shell, Pose{}, s, Pose::at(0.5, 0, 0)));
    const PairAnswer r = answer(shell, Pose{}, s, Pose::at(0.75, 0.1, 0));
    CHECK(r.signed_distance < 0);
    CHECK_FALSE(collide(shell, Pose{}, s, Pose::at(5, 0, 0)));
  }
  // Completely inside the wall.
  const Shape ball(Sphere{0.1});
  CHECK(collide(shell, Pose{}, ball, Pose::at(0.75, 0, 0)));
  CHECK(answer(shell, Pose{}, ball, Pose::at(0.75, 0, 0)).signed_distance == Approx(-0.35).margin(1e-12));
  // And a solid completely inside a convex shape.
  CHECK(collide(shell, Pose{}, Box{Vec3(9, 9, 9)}, Pose{}));
  CHECK(answer(shell, Pose{}, Box{Vec3(4, 5, 6)}, Pose{}).signed_distance == Approx(-3).margin(1e-12));
}

TEST_CASE("a solid mesh that is convex is solved as its hull: depth, normal, manifold") {
  const Shape mesh(box_mesh(Vec3(1, 2, 3), 3)), box(Box{Vec3(1, 2, 3)});
  REQUIRE(mesh_of(mesh).convex());
  CHECK_FALSE(mesh_of(Shape(torus(1, 0.3, 8, 6))).convex());
  CHECK_FALSE(mesh_of(Shape(hollow_box(Vec3(2, 2, 2), Vec3(1, 1, 1)))).convex());
  Random r(32);
  for (int i = 0; i < 40; ++i) {
    const Pose pa = random_pose(r, 1), pb = i == 0 ? pa : random_pose(r, 1);
    for (const Shape& other : {Shape(Box{Vec3(1, 2, 3)}), Shape(Sphere{0.7}), Shape(Capsule{0.3, 1})}) {
      const PairAnswer m = answer(mesh, pa, other, pb), b = answer(box, pa, other, pb);
      CAPTURE(i, name(other.kind()));
      CHECK(m.status == Status::ok);
      CHECK(m.signed_distance == Approx(b.signed_distance).margin(1e-12));
      CHECK(m.collide == b.collide);
    }
  }
  std::vector<Contact> contacts;
  NarrowPhase().solve(mesh, Pose{}, box, Pose{}, Request::contacts, &contacts);
  CHECK(contacts.size() == 4);
  for (const Contact& c : contacts) CHECK(c.depth == Approx(1).margin(1e-12));
}

TEST_CASE("depth of a convex shape in a solid: moving by it separates, and its bound holds") {
  Random r(33);
  for (const Shape& mesh : {Shape(torus(1, 0.4, 16, 12)), Shape(hollow_box(Vec3(2, 2, 2), Vec3(1.4, 1.4, 1.4)))})
    for (const Shape& shape : convex_shapes())
      for (int i = 0; i < 12; ++i) {
        const Pose pa = random_pose(r, 1), pb = moved(random_pose(r, 1.2), pa.translation);
        const PairAnswer d = answer(mesh, pa, shape, pb);
        if (d.signed_distance > 0) continue;
        const double depth = -d.signed_distance, size = mesh.size() + shape.size();
        CAPTURE(name(shape.kind()), i, depth, d.error_bound);
        CHECK_FALSE(collide(mesh, pa, shape, moved(pb, d.normal * (depth + 1e-9 * size))));
        CHECK((d.point_a - d.point_b).dot(d.normal) == Approx(depth).margin(1e-9));
        CHECK((d.status == Status::ok) == (d.error_bound == 0));
        const double certain = depth - d.error_bound;
        CHECK(certain >= -1e-12);
        for (int k = 0; k < 20; ++k)
          CHECK(collide(mesh, pa, shape, moved(pb, r.vec(-1, 1).normalized() * (0.999 * certain - 1e-12))));
      }
}

TEST_CASE("shallow overlaps with a torus: the depth is found, mostly proven, and never more than proven") {
  Random r(37);
  for (const bool solid : {true, false}) {
    Mesh ring = torus(1, 0.4, 24, 16);
    ring.solid = solid;
    const Shape mesh(ring);
    for (const Shape& shape : convex_shapes()) {
      int proven = 0, all = 0;
      for (int i = 0; i < 24; ++i) {
        const Pose pa = random_pose(r, 1);
        Pose pb = moved(random_pose(r, 2), pa.translation);
        // Also from within its tube, if that is hollow.
        const double u = r.in(0, 6);
        if (!solid && i % 3 == 0) pb.translation = pa * Vec3(std::cos(u), std::sin(u), 0);
        PairAnswer d = answer(mesh, pa, shape, pb);
        if (d.signed_distance <= 0) continue;
        const double sunk = i % 2 == 0 ? 1e-3 : 1e-2;
        pb.translation -= d.normal * (d.signed_distance + sunk);
        d = answer(mesh, pa, shape, pb);
        if (d.signed_distance > 0) continue;
        const double depth = -d.signed_distance, certain = depth - d.error_bound;
        CAPTURE(name(shape.kind()), solid, i, depth, d.error_bound);
        ++all;
        proven += d.status == Status::ok ? 1 : 0;
        CHECK(depth <= sunk * (1 + 1e-5));
        CHECK_FALSE(collide(mesh, pa, shape, moved(pb, d.normal * (depth + 1e-9))));
        // No translation is shorter than the proven bound: neither any, nor near the one found.
        for (int k = 0; k < 60; ++k) {
          const Vec3 n = k % 2 == 0 ? r.direction() : (d.normal + 0.3 * r.direction()).normalized();
          CHECK(collide(mesh, pa, shape, moved(pb, n * (0.9999 * certain))));
        }
      }
      CAPTURE(name(shape.kind()), solid);
      CHECK(all > 8);
      // For flat ones few points prove a bound.
      CHECK(proven >= (shape.kind() == ShapeKind::sphere || shape.kind() == ShapeKind::capsule ? all : all / 3));
    }
  }
}

TEST_CASE("shallow overlaps with a flat side of a solid have their exact depth") {
  const Shape wall(hollow_box(Vec3(4, 4, 4), Vec3(1, 1, 1)));
  Random r(34);
  for (const Shape& shape : convex_shapes())
    for (int i = 0; i < 10; ++i) {
      const Pose pa = random_pose(r, 1);
      Pose turned = random_pose(r, 0);
      // Lowest along the wall's z axis.
      const Bounds b = shape.bounds({pa.rotation.transpose() * turned.rotation, Vec3::Zero()});
      const double depth = std::pow(10, -1 - i);
      turned.translation = pa * Vec3(0.1 * i - 0.5, 0.3, 2 - depth - b.lo.z());
      const PairAnswer d = answer(wall, pa, shape, turned);
      CAPTURE(name(shape.kind()), i);
      CHECK(-d.signed_distance == Approx(depth).margin(1e-10).epsilon(1e-10));
      CHECK(d.normal.dot(pa.rotation.col(2)) == Approx(1));
      CHECK(d.status == Status::ok);
    }
}

TEST_CASE("shapes that slide over tessellated ground meet its plane alone") {
  Mesh slab = box_mesh(Vec3(4, 4, 1), 24);
  for (Vec3& v : slab.vertices) v.z() -= 0.5;
  struct Sample {
    Shape shape;
    double lowest;
    std::size_t points;
  };
  Pose lying;
  lying.rotation << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  Mesh pitted = slab;  // a solid that is not convex, with the same top
  for (Vec3& v : pitted.vertices)
    if (v.z() < -0.9 && std::abs(v.x()) < 0.6 && std::abs(v.y()) < 0.6) v.z() += 0.3;
  for (const Shape& ground : {Shape(level_ground(4, 24)), Shape(level_ground(4, 24, true)), Shape(pitted)})
    for (const double sunk : {0.0, 1e-9, 1e-3, 0.08})
      for (const Sample& s : {Sample{Box{Vec3(1, 0.7, 0.5)}, 0.25, 4}, Sample{Sphere{0.3}, 0.3, 1},
                              Sample{Cylinder{0.3, 0.6}, 0.3, 4}, Sample{Capsule{0.2, 0.8}, 0.2, 2}}) {
        Random r(35);
        for (int i = 0; i < 12; ++i) {
          Pose at = s.shape.kind() == ShapeKind::capsule ? lying : Pose{};
          const double angle = i < 2 ? 0 : r.in(0, 3);
          at.rotation = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix() * at.rotation;
          at.translation = Vec3{i == 0 ? 0 : r.in(-1, 1), i == 0 ? 0 : r.in(-1, 1), s.lowest - sunk};
          std::vector<Contact> contacts, shaken;
          NarrowPhase({.margin = 1e-6}).solve(ground, Pose{}, s.shape, at, Request::contacts, &contacts);
          CAPTURE(name(s.shape.kind()), sunk, i, mesh_of(ground).solid);
          CHECK(contacts.size() == s.points);
          double most = -1;
          for (const Contact& c : contacts) {
            CHECK(c.normal.z() == Approx(1));
            CHECK(c.depth == Approx(sunk).margin(1e-12));
            CHECK(c.point.z() == Approx(-sunk / 2).margin(1e-12));
            for (const Contact& o : contacts) most = std::max(most, (c.point - o.point).norm());
          }
          if (s.shape.kind() == ShapeKind::box) CHECK(most == Approx(std::hypot(1, 0.7)));
          if (s.shape.kind() == ShapeKind::capsule) CHECK(most == Approx(0.8));
          at.translation.x() += 1e-9;
          NarrowPhase({.margin = 1e-6}).solve(ground, Pose{}, s.shape, at, Request::contacts, &shaken);
          REQUIRE(shaken.size() == contacts.size());
          for (const Contact& c : contacts) {
            double nearest = 9;
            for (const Contact& o : shaken) nearest = std::min(nearest, (c.point - o.point).norm());
            if (s.shape.kind() != ShapeKind::cylinder) CHECK(nearest < 1e-7);
          }
        }
      }
}

TEST_CASE("each wall of a corner has its patch") {
  // A floor and a wall that rises from it.
  Mesh corner = level_ground(4, 8);
  const auto first = static_cast<std::uint32_t>(corner.vertices.size());
  for (const Vec3& v : level_ground(4, 8).vertices) corner.vertices.emplace_back(1, v.y(), v.x() + 2);
  for (const auto& t : level_ground(4, 8).triangles)
    corner.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  const Shape mesh(corner);
  std::vector<Contact> contacts;
  NarrowPhase().solve(mesh, Pose{}, Box{Vec3(1, 1, 1)}, Pose::at(0.5 + 0.01, 0.1, 0.5 - 0.02), Request::contacts,
                      &contacts);
  int up = 0, back = 0;
  for (const Contact& c : contacts) {
    if (c.normal.z() > 0.999) {
      ++up;
      CHECK(c.depth == Approx(0.02));
    }
    if (c.normal.x() < -0.999) {
      ++back;
      CHECK(c.depth == Approx(0.01));
    }
  }
  CHECK(up == 4);
  CHECK(back == 4);
  CHECK(contacts.size() == 8);
  contacts.clear();
  NarrowPhase().solve(mesh, Pose{}, Sphere{0.5}, Pose::at(0.51, 0.1, 0.48), Request::contacts, &contacts);
  CHECK(contacts.size() == 2);
}

// Rounding decides which of the three faces it overlaps; along the normal of one it would slide on the others.
TEST_CASE("a convex shape flush in the corner of three faces leaves them all, by no more than rounding") {
  Random r(15);
  const Shape corner = voxel_mesh(corner_cells, 1);
  int touching = 0;
  for (int i = 0; i < 600; ++i) {
    const auto [shape, half] = resting_shape(i, r);
    const Pose at_corner{r.rotation(), r.vec(-2, 2)};
    const Pose at{at_corner.rotation, at_corner * (Vec3::Ones() + half)};
    const PairAnswer distance = answer(corner, at_corner, shape, at);
    touching += distance.collide ? 1 : 0;
    CAPTURE(i, distance.signed_distance, distance.error_bound);
    CHECK(distance.status == Status::ok);
    CHECK(std::abs(distance.signed_distance) < 1e-12);
    if (distance.collide) CHECK((at_corner.rotation.transpose() * distance.normal).minCoeff() > -1e-9);
  }
  CHECK(touching > 300);
}

TEST_CASE("convex solids that overlap as meshes have the depth of their hulls") {
  const Shape a(box_mesh(Vec3(1, 2, 3), 2)), b(box_mesh(Vec3(2, 1, 1), 3));
  Random r(36);
  int hits = 0;
  for (int i = 0; i < 40; ++i) {
    const Pose pa = random_pose(r, 1), pb = i == 0 ? pa : random_pose(r, 1);
    const PairAnswer m = answer(a, pa, b, pb);
    const PairAnswer want = answer(Box{Vec3(1, 2, 3)}, pa, Box{Vec3(2, 1, 1)}, pb);
    CAPTURE(i);
    CHECK(m.collide == want.collide);
    CHECK(m.signed_distance == Approx(want.signed_distance).margin(1e-12));
    CHECK(m.status == Status::ok);
    hits += m.collide;
  }
  CHECK(hits > 10);
}

TEST_CASE("what misses a mesh by less than rounding is apart, by a little") {
  const Shape mesh(level_ground(4, 7));
  const double least = std::numeric_limits<double>::denorm_min();
  for (const double z : {0.0, least, -least, 1e-300, -1e-200, 1e-17}) {
    const Shape t(Triangle{{Vec3(0.1, 0.2, z), Vec3(0.5, 0.2, z), Vec3(0.1, 0.9, z)}});
    CAPTURE(z);
    const PairAnswer d = answer(mesh, Pose{}, t, Pose{});
    CHECK(collide(mesh, Pose{}, t, Pose{}) == (z == 0));
    CHECK((d.signed_distance <= 0) == (z == 0));
    CHECK(d.collide == (z == 0));
    CHECK(std::abs(d.signed_distance) <= 1e-15);
  }
}

TEST_CASE("triangles without area in a mesh are the segments and points that they are") {
  // Three collinear points, the third between the others, through a box.
  const std::array<Vec3, 3> line{Vec3(0.6, 0.5, 0.6), Vec3(-0.6, -0.5, -0.7), Vec3(-0.24, -0.2, -0.31)};
  const Shape mesh(Mesh{{line[0], line[1], line[2]}, {{0, 1, 2}}, false}), one(Triangle{line}), box(Box{Vec3(1, 1, 1)});
  const MeshAnswers through = answers(mesh, Pose{}, box, Pose{});
  CHECK(through.collide);
  CHECK(through.distance.signed_distance == Approx(answer(one, Pose{}, box, Pose{}).signed_distance));
  CHECK(!through.contacts.empty());

  // The translation along the other triangle's normal, an effect of rounding, is not the shortest.
  const Shape two(Mesh{{Vec3(0.2, 0.4, -1.1), Vec3(0.3, -0.2, -0.9), Vec3(0.2, 0.4, -1.1),
                        Vec3(0.00820837755841397, -0.2890612818835353, -0.3592202536913357),
                        Vec3(-0.5634604823250254, -0.17104761523968398, -0.9379941060444951),
                        Vec3(-0.27762605238330573, -0.23005444856160964, -0.6486071798679154)},
                       {{0, 1, 2}, {3, 4, 5}},
                       false});
  const Pose at = posed(Vec3(0, -1, 0.5), rows(Vec3(0.9063793512981771, 0.422464757749443, 0),
                                               Vec3(-0.422464757749443, 0.9063793512981771, 0), Vec3(0, 0, 1)));
  const MeshAnswers ball = answers(Shape(Sphere{2}), Pose::at(1.5, -0.5, 1), two, at);
  CHECK(ball.collide);
  CHECK(-ball.distance.signed_distance < 0.05);

  // Many of them: the mesh collides if one of its triangles does, and its distance is that of the nearest.
  Random r(91);
  int hits = 0;
  for (int i = 0; i < 1500; ++i) {
    Mesh soup;
    for (std::uint32_t t = 0; t < 3; ++t) {
      const Vec3 p = r.vec(-1, 1), q = r.vec(-1, 1);
      const Vec3 between = p + r.in(0, 1) * (q - p);
      for (const Vec3& v : {p, q, i % 3 == 0 ? p : i % 3 == 1 ? between : Vec3(between + 1e-12 * r.vec(-1, 1))})
        soup.vertices.push_back(v);
      soup.triangles.push_back({3 * t + t % 3, 3 * t + (t + 1) % 3, 3 * t + (t + 2) % 3});
    }
    const Shape a(soup), b = convex_shapes()[static_cast<std::size_t>(i) % 9];
    const Pose pa = random_pose(r, 1), pb = moved(random_pose(r, 0.8), pa.translation);
    const MeshAnswers found = answers(a, pa, b, pb);
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < 3; ++t)
      least = std::min(least, answer(Shape(Triangle{mesh_of(a).corners(t)}), pa, b, pb).signed_distance);
    CAPTURE(i, name(b.kind()), least, found.distance.signed_distance);
    if (std::abs(least) < 1e-12) continue;
    CHECK(found.collide == (least <= 0));
    CHECK(found.distance.collide == found.collide);
    CHECK(found.contacts.empty() != found.collide);
    if (least > 0) CHECK(found.distance.signed_distance == Approx(least).margin(1e-10));
    if (least <= 0) CHECK(found.distance.signed_distance <= least + 1e-9);
    hits += found.collide ? 1 : 0;
  }
  CHECK(hits > 100);
}

// Each side of a sliver bounds nothing along it: a chord far beyond its ends seemed to pass through it.
TEST_CASE("a solid with triangles without area is no deeper in a large triangle than beyond its plane") {
  Random r(94);
  int crossing = 0, exact = 0, deeper = 0;
  for (int i = 0; i < 600; ++i) {
    Mesh body = prism({{-.6, -.6}, {.6, -.6}, {.6, -.2}, {-.2, -.2}, {-.2, .6}, {-.6, .6}},
                      {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}}, r.in(.1, 1));
    for (int k = 0; k < 4; ++k) {  // cut at a point of a side, which the neighbour does not have
      const auto t = static_cast<std::size_t>(r.below(static_cast<int>(body.triangles.size())));
      const auto [from, to, other] = body.triangles[t];
      const auto cut = static_cast<std::uint32_t>(body.vertices.size());
      body.vertices.push_back(body.vertices[from] + r.in(.05, .95) * (body.vertices[to] - body.vertices[from]));
      body.triangles[t] = {from, cut, other};
      body.triangles.push_back({cut, to, other});
      body.triangles.push_back({from, to, cut});
    }
    const Mat3 turn = r.rotation();
    const double large = std::pow(10., r.in(1, 6)), aside = r.in(-.3, .3), along = r.in(-.3, .3);
    const Vec3 n = turn.col(2), middle = r.vec(-.4, .4);
    const Shape plate(Triangle{{large * Vec3(1, aside, 0), large * Vec3(-1, 1, 0), large * Vec3(-along, -1, 0)}});
    double above = -1e9, below = -1e9;  // how far it reaches to either side of the plane
    for (const Vec3& v : body.vertices)
      above = std::max(above, n.dot(v - middle)), below = std::max(below, -n.dot(v - middle));
    if (!(std::min(above, below) > 1e-3)) continue;
    const PairAnswer depth = answer(Shape(body), Pose{}, plate, {turn, middle});
    CAPTURE(i, large, above, below, depth.signed_distance, depth.error_bound);
    CHECK(depth.collide);
    ++crossing;
    if (depth.status == Status::ok) ++exact;
    if (-depth.signed_distance - depth.error_bound > std::min(above, below) + 1e-12 * large) ++deeper;
  }
  CHECK(crossing > 400);
  CHECK(exact > 100);
  CHECK(deeper == 0);
}

TEST_CASE("a surface apart from a convex shape: with a margin one contact is as near as they are, none nearer") {
  Random r(92);
  int within = 0;
  for (int i = 0; i < 2500; ++i) {
    const Shape a(open_shell(r)), b = convex_shapes()[static_cast<std::size_t>(i) % 9];
    const Pose pa = random_pose(r, 1);
    Pose pb = moved(random_pose(r, 1.5), pa.translation);
    const PairAnswer far = answer(a, pa, b, pb);
    const double margin = 0.2, gap = std::pow(10, r.in(-5, -0.5));
    pb.translation += far.normal * (gap - far.signed_distance);
    const MeshAnswers found = answers(a, pa, b, pb, margin);
    const double distance = found.distance.signed_distance;
    CAPTURE(i, name(b.kind()), distance);
    if (!(distance > 0) || std::abs(distance - margin) < 1e-9) continue;
    CHECK_FALSE(found.contact.collide);
    CHECK(found.contacts.empty() == (distance > margin));
    if (found.contacts.empty()) continue;
    CHECK(found.deepest == Approx(-distance).margin(1e-9));
    ++within;
  }
  CHECK(within > 1000);
}

TEST_CASE("a convex shape in a solid overlaps it with a margin as without one") {
  Random r(93);
  int inside = 0, other = 0;
  for (int i = 0; i < 1800; ++i) {
    const Shape solid(with_flat_triangles(i % 2 == 0 ? torus(1, 0.4, 8, 6) : u_body(0.6), r));
    const Shape b = i % 4 < 2 ? Shape(Sphere{r.in(0, 0.2)}) : Shape(Box{r.vec(0.05, 0.3)});
    const Pose pa = random_pose(r, 1);
    Pose pb = random_pose(r, 0);
    pb.translation = pa * (i % 2 == 0 ? Vec3{r.in(-1.3, 1.3), r.in(-1.3, 1.3), r.in(-0.3, 0.3)} : r.vec(-0.5, 2));
    const MeshAnswers plain = answers(solid, pa, b, pb), wide = answers(solid, pa, b, pb, 0.2);
    if (!(plain.distance.signed_distance < -1e-9)) continue;
    CAPTURE(i, plain.distance.signed_distance);
    CHECK(wide.contact.collide);
    REQUIRE(!plain.contacts.empty());
    // Both are the true depth within their bounds; the contacts within a margin may make another patch the deepest.
    const double bounds = plain.contact.error_bound + wide.contact.error_bound;
    CHECK(std::abs(wide.deepest - plain.deepest) <= bounds + 1e-9);
    ++inside;
    other += std::abs(wide.deepest - plain.deepest) > 1e-9;
  }
  CHECK(inside > 200);
  CHECK(other <= 1);
}

TEST_CASE("no contact of a convex shape with a concave mesh is deeper than the translation out") {
  // A cylinder beside an arm's edge.
  const Pose u_at =
      posed(Vec3(-0.55, -0.56, -0.42), rows(Vec3(0.19980418723498528, 0.14182833097808462, 0.9695168958276786),
                                            Vec3(0.8890656563310666, -0.44216546992320227, -0.11854094625994677),
                                            Vec3(0.41187442928151874, 0.8856491527346282, -0.2144412105087512)));
  const Pose at =
      posed(Vec3(0.02, 0.1, -0.66), rows(Vec3(0.10387069634101764, -0.2294720633040791, -0.967756917105014),
                                         Vec3(0.9897796151879733, -0.07174148112001033, 0.12324558103662325),
                                         Vec3(-0.09770973237083269, -0.9706676733309274, 0.21967493291303009)));
  const MeshAnswers beside = answers(Shape(u_body(0.61)), u_at, Shape(Cylinder{0.43, 0.84}), at);
  CHECK(beside.distance.status == Status::ok);
  CHECK(beside.deepest <= -beside.distance.signed_distance * (1 + 1e-8));

  Random r(94);
  int exact = 0;
  for (int i = 0; i < 2000; ++i) {
    Mesh mesh = i % 2 == 0 ? u_body(r.in(0.2, 0.8)) : torus(1, r.in(0.2, 0.5), 6, 5);
    mesh.solid = i % 4 < 2;
    const Shape a(mesh), b = convex_shapes()[static_cast<std::size_t>(i) % 9];
    const Pose pa = random_pose(r, 1);
    Pose pb = random_pose(r, 0);
    pb.translation = pa * r.vec(-1, 2);
    const PairAnswer far = answer(a, pa, b, pb);
    pb.translation -= far.normal * (far.signed_distance + std::pow(10, r.in(-6, -1.5)));
    const MeshAnswers found = answers(a, pa, b, pb);
    const double depth = -found.distance.signed_distance;
    if (!(depth > 0)) continue;
    CAPTURE(i, name(b.kind()), depth, found.deepest);
    REQUIRE(!found.contacts.empty());
    // That separates it, so no contact may be deeper.
    CHECK_FALSE(collide(a, pa, b, moved(pb, found.distance.normal * (depth + 1e-8))));
    CHECK(found.deepest <= depth * (1 + 2e-9) + 1e-11);
    exact += found.contact.status == Status::ok ? 1 : 0;
  }
  CHECK(exact > 1500);
}

TEST_CASE("a point in a solid leaves it by the nearest way") {
  const Shape ring(torus(1, 0.3, 5, 4));
  Random r(95);
  int inside = 0;
  for (int i = 0; i < 400; ++i) {
    const double u = 2 * std::numbers::pi * r.in(0, 1), v = 2 * std::numbers::pi * r.in(0, 1), tube = r.in(0, 0.3);
    const Vec3 p((1 + tube * std::cos(v)) * std::cos(u), (1 + tube * std::cos(v)) * std::sin(u), tube * std::sin(v));
    if (!collide(ring, Pose{}, Shape(Sphere{0}), Pose::at(p.x(), p.y(), p.z()))) continue;
    ++inside;
    const MeshAnswers point = answers(ring, Pose{}, Shape(Sphere{0}), Pose::at(p.x(), p.y(), p.z()));
    double depth = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < mesh_of(ring).triangles.size(); ++t)
      depth = std::min(depth, answer(Shape(Triangle{mesh_of(ring).corners(t)}), Pose{}, Shape(Sphere{0}),
                                     Pose::at(p.x(), p.y(), p.z()))
                                  .signed_distance);
    CAPTURE(i, p.transpose());
    CHECK(point.distance.status == Status::ok);
    CHECK(point.distance.signed_distance == Approx(-depth).margin(1e-12));
    CHECK(point.deepest == Approx(-point.distance.signed_distance).margin(1e-12));
  }
  CHECK(inside > 200);
}

TEST_CASE("without bounds most of the deepest contacts of a convex shape with a mesh are a translation out") {
  Random r(31);
  const NarrowPhase quick({.mesh_bounds = false});
  int deep = 0, separated = 0;
  Mesh mesh = torus(1, 0.4, 24, 16);
  mesh.solid = true;
  const Shape ring(mesh);
  for (const Shape& convex : convex_shapes())
    for (int i = 0; i < 30; ++i) {
      const Vec3 out = r.direction();
      const Pose at{r.rotation(), r.in(0.5, 1.3) * Vec3(out.x(), out.y(), 0.2 * out.z())};
      std::vector<Contact> contacts;
      const PairAnswer a = quick.solve(ring, Pose{}, convex, at, Request::contacts, &contacts);
      CAPTURE(name(convex.kind()), i);
      CHECK(a.collide == collide(ring, Pose{}, convex, at));
      if (!a.collide || contacts.empty() || a.signed_distance > -1e-6) continue;
      ++deep;
      for (const Contact& c : contacts) CHECK(c.depth <= -a.signed_distance);
      if (!collide(ring, Pose{}, convex, moved(at, (1e-9 - a.signed_distance) * a.normal))) ++separated;
    }
  CHECK(deep > 100);
  // A deepest contact as deep as the deepest triangle is accepted without examining other obstacles.
  CHECK(separated > 0.6 * deep);
}

TEST_CASE("a capsule without length has a ball's contacts with a solid, of any size") {
  const auto contacts_of = [](double scale, bool as_capsule) {
    Mesh ring = torus(1, 0.3187, 12, 8);
    for (Vec3& v : ring.vertices) v *= scale;
    const Pose turned{Eigen::AngleAxisd(0.7, Vec3(0.6, 0, 0.8)).toRotationMatrix(), scale * Vec3(0.9, 0.1, 0.25)};
    const double radius = 0.5 * scale;
    std::vector<Contact> contacts;
    NarrowPhase({.margin = 0.04 * scale})
        .solve(Shape(ring), Pose{}, as_capsule ? Shape(Capsule{radius, 0}) : Shape(Sphere{radius}), turned,
               Request::contacts, &contacts);
    for (Contact& c : contacts) c.point /= scale, c.depth /= scale;
    return contacts;
  };
  const auto same_bits = [](const Contact& x, const Contact& y) {
    return x.point == y.point && x.normal == y.normal && x.depth == y.depth && x.feature == y.feature;
  };
  const std::vector<Contact> ball = contacts_of(1, false);
  REQUIRE_FALSE(ball.empty());
  for (const int exponent : {0, 13, 84, -84})
    for (const bool as_capsule : {false, true}) {
      const std::vector<Contact> other = contacts_of(std::ldexp(1.0, exponent), as_capsule);
      CAPTURE(exponent, as_capsule, ball.size(), other.size());
      CHECK(std::equal(ball.begin(), ball.end(), other.begin(), other.end(), same_bits));
    }
}

TEST_CASE("a rod no wider than rounding does not pass between two triangles of a solid") {
  // Two cubes, so that it is not solved as its hull; the rods go through a diagonal of a face.
  const std::array<std::int32_t, 3> cells[] = {{0, 0, 0}, {5, 5, 5}};
  const Shape solid = voxel_mesh(cells, 1);
  constexpr double width = 1e-18;
  Random r(11);
  for (int i = 0; i < 3000; ++i) {
    const double at = r.in(0.05, 0.95);
    const Vec3 through(0, at, i % 2 == 0 ? at : 1 - at), along = Vec3(r.in(0.1, 1), r.in(-1, 1), r.in(-1, 1));
    const Pose pose = i % 3 == 0 ? random_pose(r, 1) : Pose{};
    const Vec3 in = pose * (through + r.in(0.01, 0.04) * along), out = pose * (through - r.in(0.01, 2) * along);
    const double length = (in - out).norm();
    const Vec3 digit = Vec3::Constant(2e-16);
    const Pose lying{Eigen::Quaterniond::FromTwoVectors(Vec3::UnitZ(), out - in).toRotationMatrix(), (in + out) / 2};
    const std::pair<Shape, Pose> rods[] = {{Shape(Convex{{in, out}}), Pose{}},
                                           {Shape(Convex{{in, out, in + digit, out - digit}}), Pose{}},
                                           {Shape(Triangle{in, out, out}), Pose{}},
                                           {Shape(Capsule{width, length}), lying},
                                           {Shape(Cylinder{width, length}), lying},
                                           {Shape(Ellipsoid{{width, width, length / 2}}), lying},
                                           {Shape(Box{Vec3(width, width, length)}), lying}};
    for (const auto& [rod, where] : rods) {
      CAPTURE(i, name(rod.kind()));
      REQUIRE(collide(solid, pose, rod, where));
      REQUIRE(answer(solid, pose, rod, where).signed_distance < 0);
      std::vector<Contact> contacts;
      NarrowPhase().solve(solid, pose, rod, where, Request::contacts, &contacts);
      REQUIRE_FALSE(contacts.empty());
    }
  }
}

TEST_CASE("a flat polygon in the plane of an edge does not pass between its two triangles") {
  const std::array<std::int32_t, 3> cells[] = {{0, 0, 0}, {5, 5, 5}};
  const Shape solid = voxel_mesh(cells, 1);
  Random r(12);
  for (int i = 0; i < 3000; ++i) {
    // About a diagonal of the face x = 0.
    const double at = r.in(0.3, 0.7), up = i % 2 == 0 ? 1 : -1;
    const Vec3 edge = Vec3(0, 1, up).normalized(), middle(0, at, i % 2 == 0 ? at : 1 - at);
    const Vec3 any = i % 5 == 0 ? Vec3(1, 0, 0) : r.direction(), across = (any - any.dot(edge) * edge).normalized();
    const Vec3 along = r.in(0.01, 0.2) * edge, one = r.in(0.01, 0.05) * across, other = -r.in(0.01, 0.05) * across;
    const Pose pose = i % 3 == 0 ? random_pose(r, 1) : Pose{};
    const Shape polygon(Convex{{pose * Vec3(middle + along + one), pose * Vec3(middle - along + one),
                                pose * Vec3(middle - along + other), pose * Vec3(middle + along + other)}});
    CAPTURE(i);
    REQUIRE(collide(solid, pose, polygon, Pose{}));
    REQUIRE(answer(solid, pose, polygon, Pose{}).signed_distance < 0);
  }
}
