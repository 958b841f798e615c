// Times of impact of translating shapes.
#include <cmath>
#include <limits>

#include "catch.h"
#include "mesh_samples.h"
#include "random_pairs.h"
#include "shapes/shape_insides.h"

using namespace tandem;
using namespace tandem::test;

TEST_CASE("time of impact: analytic answers") {
  const NarrowPhase n;
  const Shape ball(Sphere{0.5}), plate(Box{{10, 10, 1e-3}}), box(Box{{1, 1, 1}});
  const Vec3 still = Vec3::Zero();
  const auto t = n.time_of_impact(ball, Pose::at(0, 0, 5), Vec3(0, 0, -1000), plate, Pose{}, still, 1);
  REQUIRE(t);
  CHECK(std::abs(*t - (5 - 0.5 - 0.5e-3) / 1000) < 1e-14);
  CHECK_FALSE(n.time_of_impact(ball, Pose::at(0, 0, 5), Vec3(0, 0, 1), plate, Pose{}, still, 100));
  CHECK_FALSE(n.time_of_impact(ball, Pose::at(0, 0, 5), Vec3(0, 0, -1), plate, Pose{}, still, 4.4));
  CHECK(n.time_of_impact(box, Pose{}, still, box, Pose::at(1, 0, 0), Vec3(1, 0, 0), 1) == 0.0);
  const auto end = n.time_of_impact(box, Pose{}, still, box, Pose::at(3, 0, 0), Vec3(-1, 0, 0), 2);
  REQUIRE(end);
  CHECK(std::abs(*end - 2) < 1e-12);
  CHECK_FALSE(n.time_of_impact(box, Pose{}, still, box, Pose::at(3, 0, 0), still, 2));
  CHECK_THROWS_AS(n.time_of_impact(box, Pose{}, still, box, Pose{}, still, -1), std::invalid_argument);
}

TEST_CASE("time of impact: apart before it, touching at it, and never after a sampled touch") {
  Random r(13);
  const NarrowPhase n;
  int hits = 0;
  for (std::size_t ia = 0; ia < shape_kinds; ++ia)
    for (std::size_t ib = 0; ib < shape_kinds; ++ib)
      for (int i = 0; i < 8; ++i) {
        const Shape a = random_shape(static_cast<ShapeKind>(ia), r), b = random_shape(static_cast<ShapeKind>(ib), r);
        if (!n.refuses(a, b, Request::distance).empty()) continue;
        const Pose pa = random_pose(r, 1), pb = random_pose(r, 4);
        const Vec3 va = r.vec(-1, 1), vb = 2 * (pa.translation - pb.translation) + r.vec(-1, 1);
        const auto t = n.time_of_impact(a, pa, va, b, pb, vb, 2);
        CAPTURE(name(a.kind()), name(b.kind()), i);
        const auto at = [&](double time) {
          Pose qa = pa, qb = pb;
          qa.translation += time * va;
          qb.translation += time * vb;
          return n.solve(a, qa, b, qb, Request::distance).signed_distance;
        };
        if (t) {
          CHECK(at(*t) < 1e-8);
          if (*t > 1e-6) CHECK(at(*t * (1 - 1e-6)) > 0);
          ++hits;
        }
        for (int k = 0; k <= 20; ++k) {
          const double time = 0.1 * k;
          if (!t || time < *t - 1e-9) CHECK(at(time) > 0);
        }
      }
  CHECK(hits > 300);
}

TEST_CASE("time of impact: closed forms of spheres, boxes and half-spaces") {
  Random r(14);
  const NarrowPhase n;
  const Vec3 still = Vec3::Zero();
  int hits = 0;
  for (int i = 0; i < 400; ++i) {
    const double ra = r.in(0.1, 1), rb = r.in(0.1, 1);
    const Vec3 pa = r.vec(-1, 1), pb = pa + 5 * r.direction(), va = r.vec(-1, 1);
    const Vec3 towards = (pa - pb) * r.in(0.2, 2), vb = va + towards + r.vec(-2, 2);
    const Vec3 d = pb - pa, v = vb - va;
    const double a = v.squaredNorm(), b = d.dot(v), c = d.squaredNorm() - (ra + rb) * (ra + rb);
    const double disc = b * b - a * c;
    const auto t = n.time_of_impact(Sphere{ra}, {r.rotation(), pa}, va, Sphere{rb}, {r.rotation(), pb}, vb, 10);
    CAPTURE(i, disc);
    const double want = disc >= 0 ? (-b - std::sqrt(disc)) / a : -1;
    if (std::abs(disc) < 1e-9) continue;
    REQUIRE(t.has_value() == (want >= 0 && want <= 10));
    if (!t) continue;
    CHECK(std::abs(*t - want) * v.norm() <= 5e-11);
    ++hits;
  }
  CHECK(hits > 50);
  for (int i = 0; i < 200; ++i) {
    const Vec3 ha = r.vec(0.1, 1), hb = r.vec(0.1, 1), p = 4 * r.direction();
    const Vec3 towards = -p * r.in(0.2, 2), v = towards + r.vec(-0.5, 0.5);
    double enter = -1e9, leave = 1e9;
    for (int k = 0; k < 3; ++k) {
      const double x = (-p[k] - ha[k] - hb[k]) / v[k], y = (-p[k] + ha[k] + hb[k]) / v[k];
      enter = std::max(enter, std::min(x, y)), leave = std::min(leave, std::max(x, y));
    }
    const Mat3 turn = r.rotation();
    const Vec3 far = 1e5 * r.vec(-1, 1);
    for (const bool common : {false, true}) {
      const Pose pa{common ? turn : Mat3::Identity(), common ? far : still};
      const Pose pb{pa.rotation, pa.translation + pa.rotation * p};
      const auto t = n.time_of_impact(Box{2 * ha}, pa, still, Box{2 * hb}, pb, pa.rotation * v, 10);
      CAPTURE(i, common, enter, leave);
      const double rounding = common ? 1e-10 : 1e-12;
      if (std::abs(leave - enter) < 1e-6) continue;
      REQUIRE(t.has_value() == (enter <= leave && enter >= 0 && enter <= 10));
      if (t) CHECK(std::abs(*t - enter) * v.norm() <= rounding * 4);
    }
  }
  const auto t = n.time_of_impact(HalfSpace{Vec3(0, 0, 1), 0}, Pose{}, still, Shape(torus(1, 0.25, 12, 12)),
                                  Pose::at(0, 0, 1), Vec3(3, 0, -0.5), 2);
  REQUIRE(t);
  CHECK(*t == Approx(1.5).epsilon(1e-13));
}

TEST_CASE("time of impact: speeds of nothing, next to nothing and next to infinity") {
  const NarrowPhase n;
  Mesh ring = torus(0.5, 0.2, 8, 8);
  for (const Shape& s : {Shape(Box{Vec3(1, 1, 1)}), Shape(Sphere{0.5}), Shape(Cylinder{0.5, 1}), Shape(ring),
                         Shape(box_mesh(Vec3(1, 1, 1)))}) {
    const Shape wall(Box{Vec3(1, 1, 1)});
    const Pose at = Pose::at(3, 0, 0);
    CAPTURE(name(s.kind()));
    const double reach = s.kind() == ShapeKind::mesh && !mesh_of(s).convex() ? 0.7 : 0.5, gap = 2.5 - reach;
    for (const double speed : {1e-300, 1e-12, 1.0, 1e12, 1e300, 1.7e308}) {
      const Vec3 v(-speed, 0, 0);
      const double due = gap / speed;
      const double tmax = std::min(2 * due, 1e308);
      const auto t = n.time_of_impact(wall, Pose{}, Vec3::Zero(), s, at, v, tmax);
      CAPTURE(speed);
      if (std::isfinite(due) && due < tmax) {
        REQUIRE(t);
        CHECK(*t == Approx(due).epsilon(1e-12));
      }
      CHECK_FALSE(n.time_of_impact(wall, Pose{}, Vec3::Zero(), s, at, v, std::min(0.999 * due, 1e307)));
      CHECK_FALSE(n.time_of_impact(wall, Pose{}, Vec3::Zero(), s, at, v, 0));
      CHECK_FALSE(n.time_of_impact(wall, Pose{}, v, s, at, v, 1e3));
      CHECK_FALSE(n.time_of_impact(wall, Pose{}, Vec3::Zero(), s, at, -v, 1));
    }
    // Both at the largest speed, towards each other and together.
    const Vec3 most(std::numeric_limits<double>::max(), 0, 0);
    const auto t = n.time_of_impact(wall, Pose{}, most, s, at, -most, 1);
    REQUIRE(t);
    CHECK(*t <= 1e-307);
    CHECK_FALSE(n.time_of_impact(wall, Pose{}, most, s, at, most, 1));
    CHECK(n.time_of_impact(wall, Pose{}, most, s, Pose::at(0.5 + reach, 0, 0), most, 0) == 0.0);
  }
}

TEST_CASE("time of impact: no plate is too thin, no hole of a mesh too narrow") {
  const NarrowPhase n;
  const Shape sheet(Triangle{{Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0)}});
  Mesh open = torus(1, 0.4, 24, 16);
  open.solid = false;
  const Shape ring(open);
  Random r(15);
  for (const Shape& s :
       {Shape(Sphere{0.01}), Shape(Box{Vec3(0.01, 0.02, 0.01)}), Shape(Cylinder{0.01, 0.01}),
        Shape(Triangle{{Vec3(0, 0, 0), Vec3(0.01, 0, 0), Vec3(0, 0.01, 0)}}), Shape(torus(0.01, 0.002, 6, 5))})
    for (int i = 0; i < 20; ++i) {
      const Pose above{r.rotation(), Vec3{r.in(-0.3, 0.3), r.in(-0.3, 0.3), 100}};
      const Vec3 v(0, 0, -r.in(1e3, 1e6));
      CAPTURE(name(s.kind()), i);
      const auto t = n.time_of_impact(sheet, Pose{}, Vec3::Zero(), s, above, v, 1);
      REQUIRE(t);
      Pose at = above;
      at.translation += *t * v;
      CHECK(n.solve(sheet, Pose{}, s, at, Request::distance).signed_distance < 1e-10);
      CHECK(*t <= 100 / -v.z());
      // Through the ring's hole and out again; and into its tube.
      CHECK_FALSE(n.time_of_impact(ring, Pose{}, Vec3::Zero(), s, {above.rotation, Vec3(0.1, 0.2, 50)}, v, 1));
      const auto hit = n.time_of_impact(ring, Pose{}, Vec3::Zero(), s, {above.rotation, Vec3(1.1, 0.2, 50)}, v, 1);
      REQUIRE(hit);
      at.translation = Vec3(1.1, 0.2, 50) + *hit * v;
      CHECK(at.translation.z() > 0.3);
      CHECK(std::abs(n.solve(ring, Pose{}, s, at, Request::distance).signed_distance) < 1e-10);
    }
}

TEST_CASE("time of impact: grazing is never missed, passing clear never hit") {
  const NarrowPhase n;
  const Vec3 still = Vec3::Zero();
  for (const double off : {-1e-3, -1e-6, -1e-9, -1e-12, 1e-12, 1e-9, 1e-6}) {
    const auto ball =
        n.time_of_impact(Sphere{0.5}, Pose{}, still, Sphere{0.5}, Pose::at(-3, 1 + off, 0), Vec3(1, 0, 0), 9);
    const auto cube = n.time_of_impact(Box{Vec3(1, 1, 1)}, Pose{}, still, Box{Vec3(1, 1, 1)}, Pose::at(-3, 1 + off, 0),
                                       Vec3(1, 0, 0), 9);
    CAPTURE(off);
    REQUIRE(ball.has_value() == (off < 0));
    REQUIRE(cube.has_value() == (off < 0));
    if (ball) CHECK(*ball <= 3);
    if (cube) CHECK(*cube == Approx(2).epsilon(1e-12));
  }
}

TEST_CASE("time of impact of meshes is the first of all their triangles'") {
  Random r(16);
  const NarrowPhase n;
  Mesh open = torus(1, 0.3, 10, 7), other = torus(0.5, 0.2, 6, 5);
  open.solid = other.solid = false;
  const Shape ring(open), small(other);
  int hits = 0;
  for (int i = 0; i < 12; ++i) {
    const Pose pa = random_pose(r, 1);
    Pose pb = random_pose(r, 1);
    pb.translation += 4 * r.direction();
    const Vec3 v = (pa.translation - pb.translation) + r.vec(-0.8, 0.8);
    for (const Shape& s : {small, Shape(Box{Vec3(0.2, 0.3, 0.4)}), Shape(Sphere{0.2}), Shape(Cone{0.2, 0.5})}) {
      double want = 1e9;
      for (std::uint32_t x = 0; x < open.triangles.size(); ++x) {
        const Shape one(Triangle{mesh_of(ring).corners(x)});
        if (const auto t = n.time_of_impact(one, pa, Vec3::Zero(), s, pb, v, 3)) want = std::min(want, *t);
      }
      const auto t = n.time_of_impact(ring, pa, Vec3::Zero(), s, pb, v, 3);
      const auto back = n.time_of_impact(s, pb, v, ring, pa, Vec3::Zero(), 3);
      CAPTURE(i, name(s.kind()), want);
      REQUIRE(t.has_value() == (want < 1e9));
      REQUIRE(back.has_value() == t.has_value());
      if (!t) continue;
      ++hits;
      CHECK(std::abs(*t - want) * v.norm() < 1e-10);
      CHECK(std::abs(*t - *back) * v.norm() < 1e-10);
    }
  }
  CHECK(hits > 20);
}
