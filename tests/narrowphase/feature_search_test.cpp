// The search for the nearest features of two bodies.
#include "round/feature_search.h"

#include "catch.h"
#include "closed_forms/closed_forms.h"
#include "pair_classes.h"
#include "random_pairs.h"
#include "reference.h"
#include "round/feature_points.h"
#include "round/hull_projection.h"
#include "shapes/shape_insides.h"

using namespace tandem;
using namespace tandem::test;

namespace {

constexpr ShapeKind with_features[] = {ShapeKind::box, ShapeKind::capsule, ShapeKind::cylinder, ShapeKind::cone,
                                       ShapeKind::convex};

}  // namespace

TEST_CASE("features: what is found is the distance, or a depth, and most pairs are") {
  for (const ShapeKind kind_a : with_features)
    for (const ShapeKind kind_b : with_features)
      for (const reference::PairClass pair_class : reference::all_pair_classes) {
        if (pair_class == reference::PairClass::deep) continue;
        int found = 0;
        constexpr int pairs = 40;
        for (std::uint64_t i = 0; i < pairs; ++i) {
          const reference::PosedPair p = reference::make_pair({kind_a}, {kind_b}, pair_class, 40000 + i);
          const ConvexView a = view(p.a), b = view(p.b);
          const MinkowskiDifference d{a, b, relative(p.pose_a, p.pose_b)};
          const RoundPair pair(d);
          const Support s = search_features(d, -std::numeric_limits<double>::infinity());
          INFO(name(kind_a) << ' ' << name(kind_b) << ' ' << name(pair_class) << ' ' << i);
          REQUIRE(s.n.norm() == Approx(1).margin(1e-14));
          if (!s.optimal) continue;
          ++found;
          const double rounding = 1e-14 * pair.scale, radii = core_radius(a) + core_radius(b);
          REQUIRE(s.h == Approx(s.n.dot(pair.support(s.n))).margin(rounding));
          REQUIRE((s.point[0] + s.point[1] - s.h * s.n).norm() <= rounding);
          const Vec3 in_b = d.pose.rotation.transpose() * (-s.point[1] - d.pose.translation);
          const auto outside = [](const ConvexView& v, const Vec3& p) {
            if (v.hull == nullptr) return point_distance(v, p).signed_distance;
            double most = -std::numeric_limits<double>::infinity();
            for (const Hull::Face& f : v.hull->faces) most = std::max(most, f.normal.dot(p) - f.offset);
            return most;
          };
          if (a.kind != ShapeKind::capsule) REQUIRE(outside(a, s.point[0]) <= rounding);
          if (b.kind != ShapeKind::capsule) REQUIRE(outside(b, in_b) <= rounding);
          const double distance = -s.h - radii;
          const reference::Truth truth = reference::signed_distance(p.a, p.pose_a, p.b, p.pose_b);
          if (s.h < 0) REQUIRE(distance == Approx(truth.signed_distance).margin(rounding + truth.error));
          REQUIRE(distance <= truth.signed_distance + rounding + truth.error);
        }
        INFO(name(kind_a) << ' ' << name(kind_b) << ' ' << name(pair_class));
        if (pair_class != reference::PairClass::hard) CHECK(found >= pairs * 8 / 10);
      }
}

TEST_CASE("features: apart by more than asked for, only a separation is told") {
  const Shape a{Cylinder{1, 2}}, b{Cone{1, 2}};
  const ConvexView in_a = view(a), in_b = view(b);
  const MinkowskiDifference d{in_a, in_b, relative(Pose{}, Pose::at(5, 1, 0.5))};
  const Support s = search_features(d, -0.5);
  CHECK_FALSE(s.optimal);
  CHECK(s.h < -0.5);
  CHECK(s.h == Approx(s.n.dot(RoundPair(d).support(s.n))).margin(1e-14));
}

// Cones, or a cone and a line, whose common normal n is chosen first.
TEST_CASE("features: the common normal of two cones is right to rounding, however steep or flat they are") {
  Random r(11);
  int tried = 0;
  const auto side = [&](const Vec3& n, double height, Vec3& aside) {
    aside = n.cross(r.vec(-1, 1)).normalized();
    const double slant = std::hypot(1, height);  // of radius 1
    Feature f;
    f.surface = Surface::side;
    f.sine = 1 / slant, f.cosine = height / slant;
    f.axis = (f.sine * n + f.cosine * aside).normalized();
    f.low = -1e30, f.high = 1e30;
    f.point = r.vec(-1, 1);
    return f;
  };
  for (int power_a = -9; power_a <= 10; ++power_a)
    for (int power_b = -9; power_b <= 9; ++power_b)
      for (int i = 0; i < 40; ++i) {
        const Vec3 n = r.vec(-1, 1).normalized();
        Vec3 aside_a, aside_b;
        Feature a = side(n, std::pow(10.0, power_a), aside_a);
        const Feature b = side(-n, std::pow(10.0, power_b), aside_b);
        if (power_a == 10) a.surface = Surface::straight, a.sine = 0, a.cosine = 1, a.axis = aside_a;
        const double across = a.axis.cross(b.axis).norm();
        if (aside_a.cross(aside_b).norm() < 0.1 || across < 1e-3) continue;
        ++tried;
        NearestPoints w;
        w.n = n;  // of two, the nearer is meant
        w.a = w.b = Vec3::Zero();
        CAPTURE(power_a, power_b, i, across);
        nearest_points(a, b, 0, w);
        REQUIRE((w.n - n).norm() <= 200 * epsilon / across);  // the axes are rounded, too
      }
  CHECK(tried > 10000);
}

TEST_CASE("projection: points are moved into a shape, and stay where they are well inside") {
  Random r(5);
  int stayed = 0, moved = 0;
  for (const ShapeKind kind : {ShapeKind::box, ShapeKind::cylinder, ShapeKind::cone})
    for (int i = 0; i < 2000; ++i) {
      const Shape shape = random_shape(kind, r);
      const ConvexView core = view(shape);
      const double least = i % 2 == 0 ? 1e-12 : 0.05;
      const Vec3 p = r.vec(-1.2, 1.2);
      Vec3 q = p;
      const PointDistance before = point_distance(core, p);
      const bool inside = move_into(core, q, least).inside;
      if (inside) {
        ++stayed;
        REQUIRE(q == p);
        REQUIRE(before.signed_distance < -least);
        continue;
      }
      ++moved;
      REQUIRE(before.signed_distance > -2 * least);
      REQUIRE(point_distance(core, q).signed_distance <= 1e-15);
      REQUIRE((q - p).norm() == Approx(std::max(0.0, before.signed_distance)).margin(1e-14));
    }
  CHECK(stayed > 100);
  CHECK(moved > 500);
  const Shape ball{Ellipsoid{{1, 1, 1}}};
  Vec3 out{3, 0, 4}, in{0.3, 0, 0.4};
  CHECK_FALSE(move_into(view(ball), out, 0.1).inside);
  CHECK((out - Vec3(0.6, 0, 0.8)).norm() < 1e-15);
  CHECK(move_into(view(ball), in, 0.4).inside);
  CHECK_FALSE(move_into(view(ball), in, 0.6).inside);
}

TEST_CASE("projection: what of the surface is nearest") {
  const auto surface = [](const Shape& shape, Vec3 p) { return move_into(view(shape), p, 1e-12).surface; };
  const Shape box{Box{{2, 2, 2}}}, capsule{Capsule{1, 2}}, cylinder{Cylinder{1, 2}}, cone{Cone{1, 2}};
  CHECK(surface(box, {0.2, 0.3, -3}) == Surface::flat);
  CHECK(surface(box, {0.2, 2, -3}) == Surface::straight);
  CHECK(surface(box, {2, 2, -3}) == Surface::corner);
  CHECK(surface(box, {0.2, 0.3, 0.1}) == Surface::none);
  CHECK(surface(capsule, {2, 2, 0}) == Surface::straight);
  CHECK(surface(capsule, {2, 2, 4}) == Surface::corner);
  CHECK(surface(cylinder, {0.2, 0.3, -3}) == Surface::flat);
  CHECK(surface(cylinder, {2, 2, 0.5}) == Surface::straight);
  CHECK(surface(cylinder, {2, 2, 3}) == Surface::circle);
  CHECK(surface(cylinder, {0.2, 0.3, 0}) == Surface::none);
  CHECK(surface(cone, {0.2, 0.3, -3}) == Surface::flat);
  CHECK(surface(cone, {2, 2, -3}) == Surface::circle);
  CHECK(surface(cone, {2, 2, 0.5}) == Surface::side);
  CHECK(surface(cone, {0.1, 0, 5}) == Surface::corner);
}

TEST_CASE("projection: of a hull the nearest corner, edge or face, from wherever the walk begins") {
  Random r(6);
  int surfaces[6] = {}, wrong_side = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<Vec3> cloud(static_cast<std::size_t>(6 + i % 40));
    for (Vec3& v : cloud) v = r.vec(-1, 1);
    const Shape shape{Convex{cloud}};
    const Hull& hull = hull_of(shape);
    REQUIRE(has_rings(hull));
    for (int k = 0; k < 20; ++k) {
      const Vec3 p = r.vec(-3, 3);
      double above = -1;
      for (const Hull::Face& f : hull.faces) above = std::max(above, f.normal.dot(p) - f.offset);
      const NearestOnHull nearest =
          nearest_on_hull(hull, p, static_cast<std::uint32_t>(k % static_cast<int>(hull.vertices.size())));
      if (above < 0) {
        REQUIRE(nearest.surface == Surface::none);
        REQUIRE(nearest.q == p);
        continue;
      }
      if (nearest.surface == Surface::none) {  // a search that began behind the hull
        ++wrong_side;
        continue;
      }
      ++surfaces[static_cast<int>(nearest.surface)];
      // All of the hull is on the other side of the plane through q perpendicular to the direction, and q is on the
      // reported feature.
      const Vec3 from_nearest = p - nearest.q;
      for (const Vec3& v : hull.vertices) REQUIRE(from_nearest.dot(v - nearest.q) <= 1e-13);
      const Vec3 corner = hull.vertices[nearest.vertex], along = hull.vertices[nearest.other] - corner;
      if (nearest.surface == Surface::corner) REQUIRE(nearest.q == corner);
      if (nearest.surface == Surface::straight) REQUIRE((nearest.q - corner).cross(along).norm() <= 1e-14);
      if (nearest.surface != Surface::flat) continue;
      const Hull::Face& f = hull.faces[nearest.face];
      REQUIRE(std::abs(f.normal.dot(nearest.q) - f.offset) <= 1e-14);
      REQUIRE(end_on_face(hull, nearest.face, nearest.q, corner, 1e-12) == corner);
      // Far along the plane: the point where the path leaves the face is on an edge.
      const Vec3 beyond = nearest.q + 9 * any_perpendicular(f.normal);
      const Vec3 left = end_on_face(hull, nearest.face, nearest.q, beyond, 1e-12);
      REQUIRE((left - nearest.q).cross(beyond - nearest.q).norm() <= 1e-13);
      double nearest_edge = 9;
      for (std::uint32_t j = 0; j < f.count; ++j) {
        const Vec3 u = hull.vertices[hull.loop[f.first + j]], w = hull.vertices[hull.loop[f.first + (j + 1) % f.count]];
        const Vec3 out = (w - u).cross(f.normal).normalized();
        REQUIRE(out.dot(left - u) <= 1e-13);
        nearest_edge = std::min(nearest_edge, std::abs(out.dot(left - u)));
      }
      REQUIRE(nearest_edge <= 1e-13);
    }
  }
  CHECK(surfaces[static_cast<int>(Surface::corner)] > 100);
  CHECK(surfaces[static_cast<int>(Surface::straight)] > 100);
  CHECK(surfaces[static_cast<int>(Surface::flat)] > 100);
  CHECK(wrong_side < 60);
}
