// Convex hulls: properties, supports, faces.
#include "shapes/hull.h"
#include "shapes/hull_builder.h"

#include <cstdlib>
#include <fstream>
#include <iostream>
#include <numbers>
#include <set>
#include <thread>

#include "catch.h"
#include "mesh_samples.h"
#include "random_pairs.h"
#include "shapes/highest_faces.h"
#include "shapes/support.h"

using namespace tandem;
using namespace tandem::test;

namespace {

double size_of(const std::vector<Vec3>& points) {
  Vec3 lo = points[0], hi = points[0];
  for (const Vec3& p : points) lo = lo.cwiseMin(p), hi = hi.cwiseMax(p);
  return (hi - lo).norm();
}

// Checks all documented properties of a hull with faces.
void check(const Hull& hull, const std::vector<Vec3>& points) {
  const double size = size_of(points);
  const auto v = static_cast<long>(hull.vertices.size()), e = static_cast<long>(hull.edges.size()),
             f = static_cast<long>(hull.faces.size());
  CHECK(v - e + f == 2);
  double outside = 0, bent = 0;
  std::set<std::array<std::uint32_t, 2>> sides;
  for (std::uint32_t i = 0; i < hull.faces.size(); ++i) {
    const Hull::Face& face = hull.faces[i];
    CHECK(face.normal.norm() == Approx(1).epsilon(1e-12));
    CHECK(face.count >= 3);
    for (const Vec3& p : points) outside = std::max(outside, face.normal.dot(p) - face.offset);
    for (std::uint32_t k = 0; k < face.count; ++k) {
      const std::uint32_t a = hull.loop[face.first + k], b = hull.loop[face.first + (k + 1) % face.count];
      CHECK(sides.insert({a, b}).second);
      bent = std::max(bent, face.offset - face.normal.dot(hull.vertices[a]));
    }
  }
  CHECK(outside <= 1e-12 * size);
  CHECK(bent <= 1e-9 * size);
  for (const auto& s : sides) CHECK(sides.count({s[1], s[0]}) == 1);
}

// How far points lie beyond the sides of a flat hull, in its plane.
double beyond_sides(const Hull& hull, const std::vector<Vec3>& points) {
  const Hull::Face& face = hull.faces[0];
  double most = 0;
  for (std::uint32_t k = 0; k < face.count; ++k) {
    const Vec3 &from = hull.vertices[hull.loop[face.first + k]],
               &to = hull.vertices[hull.loop[face.first + (k + 1) % face.count]];
    const Vec3 outward = (to - from).cross(face.normal).normalized();
    for (const Vec3& p : points) most = std::max(most, outward.dot(p - from));
  }
  return most;
}

}  // namespace

TEST_CASE("hull of a cube with points inside and on its faces has 8 vertices, 12 edges and 6 faces") {
  std::vector<Vec3> points;
  for (int x = 0; x <= 4; ++x)
    for (int y = 0; y <= 4; ++y)
      for (int z = 0; z <= 4; ++z) points.emplace_back(x, y, z);
  const Hull hull = build_hull(points);
  CHECK(hull.dimension == 3);
  CHECK(hull.vertices.size() == 8);
  CHECK(hull.edges.size() == 12);
  CHECK(hull.faces.size() == 6);
  check(hull, points);
  for (const auto& face : hull.faces) CHECK(face.normal.cwiseAbs().maxCoeff() == 1);
}

TEST_CASE("hull of a point, a segment and a flat polygon") {
  const Vec3 p(1, 2, 3);
  CHECK(build_hull(std::vector<Vec3>{p, p, p}).dimension == 0);
  CHECK(build_hull(std::vector<Vec3>{p, p}).vertices == std::vector<Vec3>{p});
  CHECK_THROWS_AS(build_hull(std::vector<Vec3>{}), std::invalid_argument);

  const Vec3 along(0.1, -0.7, 0.3);
  std::vector<Vec3> line;
  for (const double s : {0.5, 0.0, 1.0, 0.25, 0.75}) line.push_back(p + s * along);
  const Hull segment = build_hull(line);
  CHECK(segment.dimension == 1);
  CHECK(segment.vertices == std::vector<Vec3>{line[1], line[2]});
  REQUIRE(segment.edges.size() == 1);

  std::mt19937_64 random(3);
  const Mat3 turn = random_turn(random).toRotationMatrix();
  std::vector<Vec3> flat;
  for (int x = 0; x <= 3; ++x)
    for (int y = 0; y <= 3; ++y) flat.push_back(p + turn * Vec3(x, y, 0));
  const Hull polygon = build_hull(flat);
  CHECK(polygon.dimension == 2);
  CHECK(polygon.faces.size() == 2);
  // Points rounded off an edge may remain; the corners must.
  for (const int corner : {0, 3, 12, 15})
    CHECK(std::count(polygon.vertices.begin(), polygon.vertices.end(), flat[static_cast<std::size_t>(corner)]) == 1);
  check(polygon, flat);
}

TEST_CASE("a flat hull keeps its corners and leaves out points on its edges, however many are nearly straight") {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> coordinate(-2, 2);
  int left_out = 0;
  constexpr int triangles = 2000;
  for (int i = 0; i < triangles; ++i) {
    // Legs along and across the longest extent: the points of one have the same place along it, to rounding.
    const Mat3 turn = random_turn(random).toRotationMatrix();
    const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
    std::vector<Vec3> corners;
    for (const Vec3& at : {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 1, 0)}) corners.push_back(Vec3(x, y, z) + turn * at);
    std::vector<Vec3> points = corners;
    for (const int k : {0, 1, 2}) {
      const auto from = static_cast<std::size_t>(k), to = (from + 1) % 3;
      points.push_back((corners[from] + corners[to]) / 2);
    }
    const Hull hull = build_hull(points);
    for (const Vec3& corner : corners) CHECK(std::count(hull.vertices.begin(), hull.vertices.end(), corner) == 1);
    if (hull.vertices.size() == 3) ++left_out;
    check(hull, points);
    CHECK(beyond_sides(hull, points) <= 1e-14);
  }
  CHECK(left_out > triangles / 2);

  // A needle's tip is nearer than that to the line through its neighbours, but beyond them.
  const std::vector<Vec3> needle{{0, 0, 0}, {1e-6, -1.2e-16, 0}, {1, -1e-10, 0}, {1, 1e-10, 0}};
  const Hull thin = build_hull(needle);
  CHECK(std::count(thin.vertices.begin(), thin.vertices.end(), needle[0]) == 1);

  // An edge that bulges by less from point to point than counts, and by more together.
  constexpr int count = 4000;
  std::vector<Vec3> arc{{0, -1, 0}};
  for (int i = 0; i <= count; ++i) {
    const double at = 2.0 * i / count - 1;
    arc.emplace_back(at, 1e-12 * (1 - at * at), 0);
  }
  CHECK(beyond_sides(build_hull(arc), arc) <= 1e-14);
}

TEST_CASE("a narrow face of a hull bears all its corners, and its normal is perpendicular to its sides") {
  // Blades: a corner and two points of a nearly straight line of length 1, up to 1e-11 wide, and a corner beside them.
  Random rng(5);
  for (int i = 0; i < 400; ++i) {
    const Mat3 axes = rng.rotation();
    const double width = std::pow(10, rng.in(-11, -1)), at = rng.in(0.1, 0.9);
    const Vec3 base = 0.3 * rng.direction();
    const std::vector<Vec3> corners{base, base + axes.col(0), base + at * axes.col(0) + width * axes.col(1),
                                    base - rng.in(0.01, 0.5) * axes.col(2)};
    CAPTURE(i, width);
    for (const Hull hull = build_hull(corners); const Hull::Face& face : hull.faces)
      for (std::uint32_t k = 0; k < face.count; ++k) {
        const Vec3 &from = hull.vertices[hull.loop[face.first + k]],
                   &to = hull.vertices[hull.loop[face.first + (k + 1) % face.count]];
        CHECK(std::abs(face.normal.dot(to - from)) <= 1e-15);
        CHECK(face.offset - face.normal.dot(from) <= 1e-15);
      }
  }
}

TEST_CASE("a hull's face whose corners lie on a line has a normal that bears its corners") {
  // A tetrahedron and the midpoints of its edges, which are exact: Qhull makes triangles of three collinear ones.
  std::vector<Vec3> corners{{-0.7902402877807617, -0.6212806701660156, -0.3888711929321289},
                            {-0.7051172256469727, 0.2648906707763672, 0.13526058197021484},
                            {-0.010662078857421875, -0.3474130630493164, 0.6670713424682617},
                            {-0.6271896362304688, -0.5592460632324219, -0.1459817886352539}};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) corners.push_back((corners[i] + corners[j]) / 2);
  const Hull hull = build_hull(corners);
  for (const Hull::Face& face : hull.faces) {
    CHECK(face.normal.norm() == Approx(1));
    for (std::uint32_t k = 0; k < face.count; ++k)
      CHECK(face.normal.dot(hull.vertices[hull.loop[face.first + k]]) == Approx(face.offset).margin(1e-12));
    CHECK(face.normal.dot(hull.inside) < face.offset);
  }
}

TEST_CASE("hulls of plates, needles, tiny, huge and distant clouds hold all their points") {
  std::mt19937_64 random(4);
  for (const Vec3& scale : {Vec3(1, 1, 1), Vec3(1, 1, 1e-4), Vec3(1, 1, 1e-10), Vec3(1, 1e-4, 1e-4),
                            Vec3(1e-30, 1e-30, 1e-30), Vec3(1e30, 1e30, 1e30), Vec3(1, 1e-6, 1e-11)})
    for (const double far : {0.0, 1e6}) {
      if (far > 0 && scale.maxCoeff() != 1) continue;
      const Mat3 turn = random_turn(random).toRotationMatrix();
      std::vector<Vec3> points;
      for (int i = 0; i < 60; ++i)
        points.push_back(turn * random_point(random, 1).cwiseProduct(scale) + Vec3::Constant(far));
      CAPTURE(scale.transpose());
      CAPTURE(far);
      const Hull hull = build_hull(points);
      REQUIRE(hull.dimension >= 2);
      const double size = size_of(points);
      double outside = 0;
      for (const auto& face : hull.faces)
        for (const Vec3& p : points)
          outside = std::max(outside, face.normal.dot(p - hull.inside) - (face.offset - face.normal.dot(hull.inside)));
      CHECK(outside <= 1e-12 * size + 1e-15 * far);
    }
}

TEST_CASE("every point of a sphere is a vertex, and hulls built on threads at once are the same") {
  std::mt19937_64 random(5);
  std::vector<Vec3> points;
  for (int i = 0; i < 500; ++i) points.push_back(random_point(random, 1).normalized());
  const Hull hull = build_hull(points);
  CHECK(hull.vertices == points);
  check(hull, points);
  std::array<Hull, 4> others;
  {
    std::vector<std::jthread> threads;
    for (Hull& other : others) threads.emplace_back([&] { other = build_hull(points); });
  }
  for (const Hull& other : others) CHECK(other.loop == hull.loop);
}

TEST_CASE("faces with hundreds of corners, which are built as triangles, stay whole") {
  const auto ring = [](int corners, double z, double radius) {
    std::vector<Vec3> points;
    for (int i = 0; i < corners; ++i) {
      const double angle = 2 * std::numbers::pi * i / corners;
      points.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
    return points;
  };
  const auto joined = [](std::vector<Vec3> some, const std::vector<Vec3>& others) {
    some.insert(some.end(), others.begin(), others.end());
    return some;
  };
  // Builds and checks the hull; returns its faces of so many corners.
  const auto wide = [](const std::vector<Vec3>& points, std::uint32_t corners) {
    const Hull hull = build_hull(points);
    check(hull, points);
    CHECK(hull.vertices == points);
    CHECK(hull.neighbour_face.size() == 2 * hull.edges.size());
    return std::count_if(hull.faces.begin(), hull.faces.end(), [&](const auto& face) { return face.count == corners; });
  };
  const auto cylinder = joined(ring(800, -1, 1), ring(800, 1, 1));
  CHECK(wide(cylinder, 800) == 2);
  CHECK(wide(joined(ring(1500, 0, 1), {{0, 0, 2}}), 1500) == 1);
  CHECK(wide(joined(ring(1500, 0, 1), {{0, 0, 2}, {0, 0, -2}}), 3) == 3000);
  // Sides inclined less than the triangles that the upper face is built of.
  CHECK(wide(joined(joined(ring(600, 0, 1), ring(600, 1e-3, 0.5)), {{0, 0, -1}}), 600) == 1);
  // Rounding of the corners: a facet that Qhull merges point by point breaks up.
  std::mt19937_64 random(11);
  auto rough = cylinder;
  for (Vec3& p : rough) p += random_point(random, 1e-14);
  CHECK(wide(rough, 800) == 2);
}

TEST_CASE("6,755 clouds that were hard for a hull builder") {
  const char* shared = std::getenv("TANDEM_SHARED");
  if (shared == nullptr) TANDEM_SKIP("TANDEM_SHARED, a folder with cases/ and meshes/, is not set");
  std::ifstream file(std::string(shared) + "/meshes/jolt_convex_hulls.bin", std::ios::binary);
  REQUIRE(file);
  std::uint32_t n = 0;
  int clouds = 0, flat = 0;
  double worst = 0;
  while (file.read(reinterpret_cast<char*>(&n), 4)) {
    std::vector<float> raw(3 * static_cast<std::size_t>(n));
    REQUIRE(file.read(reinterpret_cast<char*>(raw.data()), static_cast<std::streamsize>(4 * raw.size())));
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < n; ++i) points.push_back(Eigen::Map<Eigen::Vector3f>(&raw[3 * i]).cast<double>());
    const Hull hull = build_hull(points);
    REQUIRE(hull.dimension >= 2);
    flat += hull.dimension == 2;
    if (hull.dimension == 3) REQUIRE(hull.vertices.size() + hull.faces.size() == hull.edges.size() + 2);
    const double size = size_of(points);
    for (const auto& face : hull.faces)
      for (const Vec3& p : points) worst = std::max(worst, (face.normal.dot(p) - face.offset) / size);
    ++clouds;
  }
  CHECK(clouds == 6755);
  CHECK(flat < 50);
  CHECK(worst <= 1e-12);
}

TEST_CASE("support maps find the vertex and the face that a scan of all finds, the first among equals") {
  Random r(21);
  std::vector<std::vector<Vec3>> clouds(12);
  for (int i = 0; i < 3000; ++i) clouds[9].push_back(r.direction());  // some 90 in a chamber
  for (int i = 0; i < 400; ++i) {
    const Vec3 d = r.direction();
    if (i < 32) clouds[0].push_back(d);
    if (i < 256) clouds[1].push_back(1e-6 * d);
    if (i < 100) clouds[2].push_back(d.cwiseProduct(Vec3(1, 1e-4, 1e-4)));
    if (i < 100) clouds[3].push_back(d.cwiseProduct(Vec3(1, 1, 1e-4)) + Vec3(0, 0, 3));
    if (i < 60) clouds[4].emplace_back(std::cos(0.1 * i), std::sin(0.1 * i), 0);
    clouds[5].push_back(d + Vec3(1e3, 0, 0));
    if (i < 64) clouds[6].emplace_back(i % 4, i / 4 % 4, i / 16);
    if (i < 60) clouds[7].emplace_back(std::cos(0.1 * i), std::sin(0.1 * i), i % 2);
    if (i < 6) clouds[8].push_back(d);
    if (i < 48) clouds[10].push_back(1e-30 * d);
    if (i < 48) clouds[11].push_back(d.cwiseProduct(Vec3(1e-30, 1e30, 1)));
  }
  for (const auto& cloud : clouds) {
    const Hull hull = build_hull(cloud);
    REQUIRE((hull.faces.size() <= 4 || hull.normals.empty() == (hull.face_table.faces > 0)));
    const ConvexView v{.kind = ShapeKind::convex, .param = {}, .vertices = hull.vertices, .hull = &hull, .size = 1};
    for (int i = 0; i < 4000; ++i) {
      Vec3 d = r.direction();
      if (i % 3 == 1) d = Vec3(i / 3 % 3 - 1, i / 9 % 3 - 1, i / 27 % 3 - 1);  // along the chambers' edges
      if (i % 3 == 2) d[i / 3 % 3] = i % 2 == 0 ? 0.0 : -0.0;
      if (i % 7 == 3 && !hull.faces.empty()) d = hull.faces[static_cast<std::size_t>(i) % hull.faces.size()].normal;
      if (d == Vec3::Zero()) continue;
      if (i % 5 == 1) d *= i % 2 == 0 ? 1e-40 : 1e40;
      const auto farthest = [&d](std::size_t count, const auto& place) {
        const auto along = [&](std::uint32_t k) {
          const Vec3& p = place(k);
          return p[0] * d[0] + p[1] * d[1] + p[2] * d[2];
        };
        std::uint32_t best = 0;
        for (std::uint32_t k = 1; k < count; ++k)
          if (along(k) > along(best)) best = k;
        return best;
      };
      const auto vertex = [&](std::uint32_t k) -> const Vec3& { return hull.vertices[k]; };
      const auto normal = [&](std::uint32_t k) -> const Vec3& { return hull.faces[k].normal; };
      REQUIRE(core_support_point(v, d, support_kernel()).vertex == farthest(hull.vertices.size(), vertex));
      if (!hull.normals.empty()) REQUIRE(face_kernel()(hull, d.data()) == farthest(hull.faces.size(), normal));
    }
  }
}

TEST_CASE(
    "the highest face over a point is among those that single precision leaves, near and far, of any size and place") {
  Random r(163);
  int asked = 0, left = 0, far = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<Vec3> points;
    const double shift = i % 3 == 0 ? std::pow(10.0, r.in(0, 9)) : 0;
    const Vec3 away = i % 3 == 0 ? Vec3(shift * r.direction()) : Vec3(Vec3::Zero());
    const double size = std::ldexp(1.0, i % 3 == 0 ? 0 : static_cast<int>(r.in(-90, 90)));
    const Vec3 stretch(1, std::pow(10.0, r.in(-5, 0)), i % 2 == 0 ? 1 : 0.3);
    for (int k = 0; k < 8 + i % 50; ++k) points.push_back(size * (stretch.cwiseProduct(r.direction()) + away));
    const Hull hull = build_hull(points);
    const std::size_t n = hull.face_table.faces;
    if (n == 0) continue;
    for (int k = 0; k < 60; ++k) {
      const double distance = k % 3 == 0 ? std::pow(10.0, r.in(-8, 0)) : k % 3 == 1 ? 1 : std::pow(10.0, r.in(0, 150));
      const Vec3 p = hull.inside + size * distance * stretch.cwiseProduct(r.direction());
      const auto height = [&](std::size_t f) { return hull.faces[f].normal.dot(p) - hull.faces[f].offset; };
      std::size_t most = 0;
      for (std::size_t f = 1; f < n; ++f)
        if (height(f) > height(most)) most = f;
      std::size_t found = n, count = 0;
      for_each_face(faces_over(hull, p), [&](std::size_t f) {
        REQUIRE(f < n);
        if (found == n || height(f) > height(found)) found = f;
        ++count;
      });
      REQUIRE(found == most);
      ++asked, far += count == n;
      if (away.isZero() && distance == 1 && stretch[1] > 0.01) left += static_cast<int>(count);
    }
  }
  CHECK(asked > 10000);
  CHECK(far > 1000);
  CHECK(left < asked / 3);
}

TEST_CASE("the face that looks most along a direction is among those that single precision leaves, and these are few") {
  Random r(162);
  int asked = 0, several = 0, left = 0, plump = 0;
  for (int i = 0; i < 200; ++i) {
    std::vector<Vec3> points;
    const Vec3 stretch(1, std::pow(10.0, r.in(-7, 0)), i % 2 == 0 ? 1 : 0.3);
    for (int k = 0; k < 8 + i % 50; ++k) points.push_back(stretch.cwiseProduct(r.direction()));
    const Hull hull = build_hull(points);
    const std::size_t n = hull.face_table.faces;
    if (n == 0) continue;
    for (int k = 0; k < 50; ++k) {
      Vec3 d = r.direction();
      if (k % 3 == 0) {  // as far along one face as along its neighbour, to rounding
        const Hull::Edge& edge =
            hull.edges[static_cast<std::size_t>(r.in(0, 1) * static_cast<double>(hull.edges.size()))];
        d = (hull.faces[edge.face[0]].normal + hull.faces[edge.face[1]].normal).stableNormalized();
        if (!(d.norm() > 0.5)) continue;
      }
      std::size_t most = 0;
      for (std::size_t f = 1; f < n; ++f)
        if (hull.faces[f].normal.dot(d) > hull.faces[most].normal.dot(d)) most = f;
      const FaceBits bits = faces_along(hull.face_table, d);
      REQUIRE((bits[most / 64] >> most % 64 & 1) == 1);
      int count = 0;
      for (std::size_t f = 0; f < FaceTable::most_faces; ++f) {
        const bool is_left = (bits[f / 64] >> f % 64 & 1) != 0;
        if (is_left) REQUIRE(f < n);
        count += is_left;
      }
      ++asked, several += count > 1;
      if (stretch[1] > 0.01) ++plump, left += count;  // the normals of a needle's sides all lie in one plane
    }
  }
  CHECK(asked > 5000);
  CHECK(several > 500);
  CHECK(plump > 2000);
  CHECK(left < 2 * plump);
}
