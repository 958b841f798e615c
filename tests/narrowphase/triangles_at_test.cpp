// The triangles at a contact's point.
#include "tandem/narrowphase/triangles_at.h"

#include <cmath>
#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "random.h"
#include "tandem/narrowphase/narrow_phase.h"

using namespace tandem;
using namespace tandem::test;

namespace {

Shape one_triangle(const Mesh& mesh, std::uint32_t t) {
  const auto& corners = mesh.triangles[t];
  return Shape(Triangle{mesh.vertices[corners[0]], mesh.vertices[corners[1]], mesh.vertices[corners[2]]});
}

double distance_of(const Shape& triangle, const Pose& pose, const Vec3& place) {
  return NarrowPhase()
      .solve(triangle, pose, Shape(Sphere{0}), {Mat3::Identity(), place}, Request::distance)
      .signed_distance;
}

}  // namespace

TEST_CASE("triangles at: the nearest triangle, and beside an edge the one that faces outward") {
  const Mesh box = box_mesh({2, 2, 2}, 1);
  const Shape solid(box);
  const Pose pose{Mat3::Identity(), {1, 2, 3}};
  const auto normal_of = [&](std::uint32_t t) {
    const auto& c = box.triangles[t];
    const Vec3 v = box.vertices[c[0]];
    return Vec3((box.vertices[c[1]] - v).cross(box.vertices[c[2]] - v).normalized());
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      Vec3 outward = side * Vec3::Unit(axis);
      const Vec3 corner = pose.translation + Vec3(1, 1, 1).cwiseProduct(side * Vec3::Ones());
      CHECK((normal_of(triangle_at(solid, pose, corner, outward)) - outward).norm() < 1e-12);
      // Near the face's middle only the position counts.
      outward = Vec3::Unit((axis + 1) % 3);
      const Vec3 middle = pose.translation + 1.01 * side * Vec3::Unit(axis) + 0.1 * outward;
      CHECK((normal_of(triangle_at(solid, pose, middle, outward)) - side * Vec3::Unit(axis)).norm() < 1e-12);
    }
  CHECK(triangle_at(Shape(Sphere{1}), pose, {0, 0, 0}, {1, 0, 0}) == 0);
}

TEST_CASE("triangles at: those of witness points and contacts hold them, of convex shapes and meshes") {
  const NarrowPhase solver;
  Mesh ring = torus(1, 0.4, 20, 10);
  const Mesh open = [&] {
    Mesh m = torus(0.8, 0.3, 16, 8);
    m.triangles.resize(m.triangles.size() / 2);
    m.solid = false;
    return m;
  }();
  reference::Random random(11);
  int points = 0, contacts_seen = 0;
  for (int i = 0; i < 120; ++i) {
    const Pose pose_a{random.rotation(), random.vec(-1, 1)}, pose_b{random.rotation(), random.vec(-1.5, 1.5)};
    const Shape a(ring), b = i % 2 == 0 ? Shape(Box{{0.3, 0.4, 0.5}}) : Shape(open);
    const auto check = [&](const std::array<std::uint32_t, 2>& at, const Vec3& on_a, const Vec3& on_b, double slack) {
      CHECK(std::abs(distance_of(one_triangle(ring, at[0]), pose_a, on_a)) < slack);
      if (i % 2 == 1) CHECK(std::abs(distance_of(one_triangle(open, at[1]), pose_b, on_b)) < slack);
      if (i % 2 == 0) CHECK(at[1] == 0);
    };
    const PairAnswer near = solver.solve(a, pose_a, b, pose_b, Request::distance);
    if (near.signed_distance > 0)
      ++points, check(triangles_at(a, pose_a, b, pose_b, near), near.point_a, near.point_b, 1e-12);
    std::vector<Contact> contacts;
    solver.solve(a, pose_a, b, pose_b, Request::contacts, &contacts);
    for (const Contact& c : contacts) {
      const auto at = triangles_at(a, pose_a, b, pose_b, c);
      CHECK(at[0] < ring.triangles.size());
      // No other triangle of A is nearer to the contact's point on A.
      const Vec3 on_a = c.point + c.depth / 2 * c.normal;
      const double chosen = distance_of(one_triangle(ring, at[0]), pose_a, on_a);
      if (++contacts_seen % 8 == 0)
        for (std::uint32_t t = 0; t < ring.triangles.size(); ++t)
          if (distance_of(one_triangle(ring, t), pose_a, on_a) < chosen - 1e-12) FAIL_CHECK("pair " << i << ", " << t);
    }
  }
  CHECK(points > 30);
  CHECK(contacts_seen > 100);
}
