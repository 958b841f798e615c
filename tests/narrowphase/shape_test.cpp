// Shapes: checks, bounds, mass, memory.
#include "tandem/narrowphase/shape.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <random>
#include <thread>
#include <type_traits>
#include <vector>

#include "catch.h"
#include "mesh_samples.h"
#include "random.h"
#include "shapes/mesh_builder.h"
#include "shapes/mesh_hierarchy.h"
#include "shapes/shape_insides.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/shape_memory.h"

using namespace tandem;
using namespace tandem::test;
using Catch::Matchers::Contains;

namespace {

Shape tetrahedron() { return Shape(Convex{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 2, 0), Vec3(0, 0, 3)}}); }

// True if the shape contains the point, by definition; for kinds with a closed form.
bool holds(const Shape& s, const Vec3& p) {
  const double across = p.head<2>().norm();
  switch (s.kind()) {
    case ShapeKind::sphere:
      return p.norm() <= s.radius();
    case ShapeKind::box:
      return (p.cwiseAbs() - s.half_size()).maxCoeff() <= 0;
    case ShapeKind::capsule:
      return (p - Vec3(0, 0, std::clamp(p.z(), -s.length() / 2, s.length() / 2))).norm() <= s.radius();
    case ShapeKind::cylinder:
      return across <= s.radius() && std::abs(p.z()) <= s.length() / 2;
    case ShapeKind::cone:
      return std::abs(p.z()) <= s.length() / 2 && across <= s.radius() * (0.5 - p.z() / s.length());
    case ShapeKind::ellipsoid:
      return p.cwiseQuotient(s.radii()).norm() <= 1;
    default: {
      for (const auto& face : hull_of(s).faces)
        if (face.normal.dot(p) > face.offset) return false;
      return true;
    }
  }
}

}  // namespace

TEST_CASE("shapes refuse what they cannot be, by the field's name") {
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(Shape(Sphere{-1}), Contains("sphere: radius is -1"));
  CHECK_THROWS_WITH(Shape(Sphere{nan}), Contains("radius"));
  CHECK_THROWS_WITH(Shape(Box{Vec3(1, 0, 1)}), Contains("box: size[1] is 0"));
  CHECK_THROWS_WITH(Shape(Box{Vec3(1, 1, inf)}), Contains("size[2]"));
  CHECK_THROWS_WITH(Shape(Capsule{0, 1}), Contains("capsule: radius"));
  CHECK_THROWS_WITH(Shape(Capsule{1, -1}), Contains("capsule: length"));
  CHECK_THROWS_WITH(Shape(Cylinder{1, 0}), Contains("cylinder: length"));
  CHECK_THROWS_WITH(Shape(Cone{1, nan}), Contains("cone: length"));
  CHECK_THROWS_WITH(Shape(Ellipsoid{Vec3(1, 2, -3)}), Contains("ellipsoid: radii[2] is -3"));
  CHECK_THROWS_WITH(Shape(HalfSpace{Vec3::Zero(), 1}), Contains("halfspace: length of normal"));
  CHECK_THROWS_WITH(Shape(HalfSpace{Vec3::UnitX(), inf}), Contains("halfspace: offset"));
  CHECK_THROWS_WITH(Shape(Plane{Vec3::Zero(), 1}), Contains("plane: length of normal"));
  CHECK_THROWS_WITH(Shape(Convex{}), Contains("convex: vertices is empty"));
  CHECK_THROWS_WITH(Shape(Convex{{Vec3(0, 0, 0), Vec3(0, nan, 0)}}), Contains("convex: vertices[1][1]"));
  CHECK_THROWS_WITH(Shape(Triangle{{Vec3(0, 0, 0), Vec3(0, 0, 0), Vec3(0, 0, inf)}}),
                    Contains("triangle: vertices[2][2]"));
  CHECK_NOTHROW(Shape(Sphere{0}));
  CHECK_NOTHROW(Shape(Capsule{1, 0}));
  CHECK_NOTHROW(Shape(Triangle{{Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1)}}));
}

TEST_CASE("shapes tell their vertices and triangles") {
  const std::vector<Vec3> corners = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  std::vector<Vec3> more = corners;
  more.insert(more.begin() + 1, Vec3(0.1, 0.1, 0.1));
  const Shape hull{Convex{more}};
  CHECK(std::vector(hull.vertices().begin(), hull.vertices().end()) == corners);
  CHECK(hull.triangles().empty());
  CHECK(hull.is_solid());

  const Shape flat(Triangle{{corners[0], corners[1], corners[1]}});
  CHECK(flat.vertices().size() == 3);
  CHECK(flat.triangles().size() == 1);
  CHECK_FALSE(flat.is_solid());

  const std::vector<std::array<std::uint32_t, 3>> faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  for (const bool solid : {false, true}) {
    const Shape mesh(Mesh{corners, faces, solid});
    CHECK(std::vector(mesh.vertices().begin(), mesh.vertices().end()) == corners);
    CHECK(std::vector(mesh.triangles().begin(), mesh.triangles().end()) == faces);
    CHECK(mesh.is_solid() == solid);
  }

  const Shape ball(Sphere{1});
  CHECK(ball.vertices().empty());
  CHECK(ball.triangles().empty());
  CHECK(ball.is_solid());
}

TEST_CASE("shapes that are costly to build are not built by the way") {
  static_assert(!std::is_convertible_v<Mesh, Shape> && !std::is_convertible_v<Convex, Shape>);
  static_assert(std::is_convertible_v<Box, Shape> && std::is_convertible_v<Triangle, Shape>);
}

TEST_CASE("poses: rotations of float precision pass, others do not") {
  std::mt19937_64 random(1);
  for (int i = 0; i < 200; ++i) {
    Pose pose = random_pose(random, 10);
    pose.rotation = pose.rotation.cast<float>().cast<double>();
    CHECK_NOTHROW(require_valid(pose, "body 3"));
  }
  Pose scaled;
  scaled.rotation *= 1 + 1e-5;
  CHECK_THROWS_WITH(require_valid(scaled, "body 3"), Contains("body 3: rotation is off"));
  Pose mirrored;
  mirrored.rotation(2, 2) = -1;
  CHECK_THROWS_WITH(require_valid(mirrored, "body 3"), Contains("determinant"));
  Pose lost;
  lost.translation.y() = std::nan("");
  CHECK_THROWS_WITH(require_valid(lost, "body 3"), Contains("translation[1]"));
  Pose bent;
  bent.rotation(0, 1) = std::nan("");
  CHECK_THROWS_WITH(require_valid(bent, "body 3"), Contains("rotation(0, 1)"));
}

TEST_CASE("bounds hold the shape and touch it on all six sides") {
  std::mt19937_64 random(2);
  const std::vector<Shape> shapes{Sphere{0.7},        Box{Vec3(1, 2, 3)}, Capsule{0.3, 1.2},
                                  Cylinder{0.5, 1.5}, Cone{0.6, 1.1},     Ellipsoid{Vec3(0.2, 0.9, 1.4)},
                                  tetrahedron()};
  for (const Shape& shape : shapes)
    for (int i = 0; i < 3; ++i) {
      const Pose pose = random_pose(random, 5);
      const Bounds b = shape.bounds(pose);
      Vec3 lo = Vec3::Constant(1e9), hi = -lo;
      for (int k = 0; k < 40000; ++k) {
        // Projects random points to the surface along a ray from an inner point.
        const Vec3 d = random_point(random, 1).normalized();
        const Vec3 from = shape.kind() == ShapeKind::convex ? hull_of(shape).inside : Vec3(0, 0, 0);
        double in = 0, out = shape.size();
        for (int step = 0; step < 30; ++step) (holds(shape, from + (in + out) / 2 * d) ? in : out) = (in + out) / 2;
        const Vec3 p = pose * Vec3(from + in * d);
        lo = lo.cwiseMin(p);
        hi = hi.cwiseMax(p);
      }
      CAPTURE(name(shape.kind()));
      CHECK((lo - b.lo).minCoeff() >= -1e-6);
      CHECK((b.hi - hi).minCoeff() >= -1e-6);
      CHECK((lo - b.lo).maxCoeff() <= 0.2 * shape.size());
      CHECK((b.hi - hi).maxCoeff() <= 0.2 * shape.size());
    }
  const Mesh mesh = torus(1, 0.3, 12, 9);
  const Pose pose = random_pose(random, 5);
  Vec3 lo = Vec3::Constant(1e9), hi = -lo;
  for (const Vec3& v : mesh.vertices) lo = lo.cwiseMin(pose * v), hi = hi.cwiseMax(pose * v);
  const Bounds b = Shape(mesh).bounds(pose);
  CHECK((b.lo - lo).norm() < 1e-14);
  CHECK((b.hi - hi).norm() < 1e-14);
  const Bounds ground = Shape(HalfSpace{Vec3(0, 0, 2), 3}).bounds(Pose::at(0, 0, 1));
  CHECK(ground.hi.z() == 2.5);
  CHECK(ground.lo.z() == -1e300);
  CHECK(ground.hi.x() == 1e300);
}

TEST_CASE("mass properties agree with sampling") {
  const std::vector<Shape> shapes{Sphere{0.7},        Box{Vec3(1, 2, 3)}, Capsule{0.3, 1.2},
                                  Cylinder{0.5, 1.5}, Cone{0.6, 1.1},     Ellipsoid{Vec3(0.2, 0.9, 1.4)},
                                  tetrahedron()};
  for (const Shape& shape : shapes) {
    const Bounds b = shape.bounds(Pose{});
    const int n = 60;
    const Vec3 step = (b.hi - b.lo) / n;
    double volume = 0;
    Vec3 first = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    for (int x = 0; x < n; ++x)
      for (int y = 0; y < n; ++y)
        for (int z = 0; z < n; ++z) {
          const Vec3 p = b.lo + step.cwiseProduct(Vec3(x + 0.5, y + 0.5, z + 0.5));
          if (!holds(shape, p)) continue;
          volume += 1, first += p, second += p * p.transpose();
        }
    const double cell = step.prod();
    const Vec3 centre = first / volume;
    const Mat3 spread = (second - volume * centre * centre.transpose()) * cell;
    const Mat3 inertia = spread.trace() * Mat3::Identity() - spread;
    const MassProperties m = shape.mass();
    CAPTURE(name(shape.kind()));
    CHECK(m.volume == Approx(volume * cell).epsilon(0.02));
    CHECK((m.centre - centre).norm() < 0.01 * shape.size());
    CHECK((m.inertia - inertia).norm() < 0.03 * inertia.norm());
  }
  const MassProperties cube = Shape(box_mesh(Vec3(1, 2, 3), 2)).mass(), box = Shape(Box{Vec3(1, 2, 3)}).mass();
  CHECK(cube.volume == Approx(box.volume));
  CHECK((cube.inertia - box.inertia).norm() < 1e-12);
  const MassProperties flat = Shape(Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}}).mass();
  CHECK(flat.volume == Approx(std::sqrt(2.0) / 100));
  CHECK(Shape(Mesh{torus(1, 0.3, 64, 64)}).mass().volume ==
        Approx(2 * std::numbers::pi * std::numbers::pi * 0.09).epsilon(0.01));
}

TEST_CASE("meshes refuse what they cannot be, by the field's name") {
  Mesh mesh = box_mesh(Vec3(1, 1, 1));
  CHECK_NOTHROW(Shape(mesh));
  Mesh empty;
  CHECK_THROWS_WITH(Shape(empty), Contains("triangles is empty"));
  Mesh wild = mesh;
  wild.triangles[3][1] = 99;
  CHECK_THROWS_WITH(Shape(wild), Contains("triangles[3][1] is 99"));
  Mesh lost = mesh;
  lost.vertices[2].x() = std::nan("");
  CHECK_THROWS_WITH(Shape(lost), Contains("mesh: vertices[2][0]"));
  Mesh open = mesh;
  open.triangles.pop_back();
  CHECK_THROWS_WITH(Shape(open), Contains("the edge ("));
  open.solid = false;
  CHECK_NOTHROW(Shape(open));
  Mesh turned = mesh;
  std::swap(turned.triangles[0][0], turned.triangles[0][1]);
  CHECK_THROWS_WITH(Shape(turned), Contains("the edge ("));
  Mesh inward = mesh;
  for (auto& t : inward.triangles) std::swap(t[0], t[1]);
  CHECK_THROWS_WITH(Shape(inward), Contains("volume"));
}

TEST_CASE("a mesh's hierarchy holds every triangle once, in boxes around it") {
  Mesh input = torus(1, 0.3, 24, 24);
  for (Vec3& v : input.vertices) v += Vec3(1e6, 0, -3);
  const MeshModel mesh = build_mesh(input);
  std::vector<int> seen(mesh.triangles.size(), 0);
  for (const MeshNode& node : mesh.nodes) {
    if (!node.bottom()) continue;
    LaneBoxes boxes;
    mesh.boxes_of_triangles(node, boxes);
    for (std::uint32_t k = 0; k < node.lanes(); ++k) {
      const std::uint32_t t = mesh.triangle_of(node, k);
      ++seen[t];
      float mid[3], half[3];
      box_of_triangle(mesh, t, mid, half);
      for (const Vec3& p : mesh.corners(t))
        for (int axis = 0; axis < 3; ++axis) {
          const double at = (p[axis] - mesh.centre[axis]) / mesh.unit;
          CHECK(std::abs(at - static_cast<double>(boxes.mid[axis][k])) <= static_cast<double>(boxes.half[axis][k]));
          CHECK(std::abs(at - static_cast<double>(mid[axis])) <= static_cast<double>(half[axis]));
        }
    }
  }
  CHECK(std::all_of(seen.begin(), seen.end(), [](int n) { return n == 1; }));
  for (const auto& n : mesh.neighbours())
    for (const std::uint32_t t : n) CHECK(t != no_index);
}

TEST_CASE("corners of a surface that differ by rounding are one, as equal ones are") {
  const Mesh whole = torus(1, 0.3, 12, 12);
  const auto apart = [&](double by) {
    Mesh soup;
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> some(-by, by);
    for (const auto& t : whole.triangles) {
      const auto first = static_cast<std::uint32_t>(soup.vertices.size());
      for (const std::uint32_t v : t)
        soup.vertices.push_back(whole.vertices[v] + Vec3{some(random), some(random), some(random)});
      soup.triangles.push_back({first, first + 1, first + 2});
    }
    return soup;
  };
  const auto expected = build_mesh(whole).neighbours();
  for (const double by : {0.0, 2e-16, 1e-15}) {
    CAPTURE(by);
    const MeshModel mesh = build_mesh(apart(by));
    CHECK(mesh.closed);
    CHECK(mesh.components().size() == 1);
    CHECK(mesh.neighbours() == expected);
    // A ball that rests on it has one contact, and none from inner edges.
    std::vector<Contact> contacts;
    NarrowPhase().solve(Shape(apart(by)), {}, Sphere{0.2}, Pose::at(1, 0.02, 0.49), Request::contacts, &contacts);
    CHECK(contacts.size() == 1);
  }
  for (const double by : {1e-13, 1e-9}) {
    const MeshModel mesh = build_mesh(apart(by));
    CHECK_FALSE(mesh.closed);
    CHECK(mesh.components().size() == whole.triangles.size());
  }
  Mesh solid = apart(1e-15);
  solid.solid = true;
  CHECK_THROWS_WITH(Shape(solid), Contains("the edge ("));
}

TEST_CASE("shape: a half-space made of a half-space's normal and offset is the same bits") {
  reference::Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const Shape once(HalfSpace{random.vec_of_length(0.1, 10), random.in(-5, 5)});
    const Shape twice(HalfSpace{once.normal(), once.offset()});
    CHECK(twice.parameters() == once.parameters());
  }
}

TEST_CASE("meshes: built by parts on several threads, or by hand in any order, the hierarchy is the same") {
  const Mesh input = torus(1, 0.4, 320, 160);  // more triangles than one thread takes
  const MeshModel alone = build_mesh(input);
  const PartRunner backwards = [](std::size_t parts, const std::function<void(std::size_t)>& part) {
    for (std::size_t k = parts; k-- > 0;) part(k);
  };
  const PartRunner at_once = [](std::size_t parts, const std::function<void(std::size_t)>& part) {
    std::vector<std::thread> threads;
    for (std::size_t k = 0; k < parts; ++k) threads.emplace_back(part, k);
    for (std::thread& thread : threads) thread.join();
  };
  for (const PartRunner& runner : {backwards, at_once}) {
    const MeshModel shared = build_mesh(input, {.parts = runner});
    REQUIRE(shared.nodes.size() == alone.nodes.size());
    CHECK(std::memcmp(shared.nodes.data(), alone.nodes.data(), alone.nodes.size() * sizeof(MeshNode)) == 0);
    CHECK(std::memcmp(shared.blocks.data(), alone.blocks.data(), alone.blocks.size() * sizeof(TriangleBlock)) == 0);
    REQUIRE(shared.slabs.size() == alone.slabs.size());
    CHECK(std::memcmp(shared.boxes.data(), alone.boxes.data(), alone.boxes.size() * sizeof(ChildBoxes)) == 0);
    CHECK(shared.order == alone.order);
    CHECK(shared.extreme() == alone.extreme());
    CHECK(shared.depth == alone.depth);
    CHECK(shared.memory().total() == alone.memory().total());
  }
  const Shape shape(input);
  CHECK(shape.memory() > 90 * input.triangles.size());
  CHECK(shape.memory() < 100 * input.triangles.size());
}

TEST_CASE("shapes: what several share of memory is counted once") {
  const Shape mesh(torus(1, 0.4, 40, 20)), hull = tetrahedron(), ball = Sphere{1};
  constexpr std::size_t own = 256;  // bytes: more than a shape holds beside what it shares
  const auto both = [](const Shape& a, const Shape& b) { return memory_of(std::array<Shape, 2>{a, b}); };
  CHECK(memory_of(std::array<Shape, 1>{mesh}) == mesh.memory());
  CHECK(both(mesh, mesh) == mesh.memory());
  CHECK(both(mesh, hull) == mesh.memory() + hull.memory());
  for (const Shape& shape : {mesh, hull}) {
    const std::size_t rounded = both(shape, shape.rounded(0.1));
    CHECK(rounded > shape.memory());
    CHECK(rounded < shape.memory() + own);
  }
  CHECK(memory_of({}) == 0);
}

TEST_CASE("hulls: their memory is that of all that they hold") {
  const Shape small_shape = tetrahedron();
  const Hull& small = hull_of(small_shape);
  CHECK(small.memory() >= sizeof(Hull) + 4 * sizeof(Vec3));
  std::vector<Vec3> points;
  reference::Random r(5);
  for (int i = 0; i < 40; ++i) points.push_back(r.direction());
  const Shape shape{Convex{points}};
  const Hull& hull = hull_of(shape);
  REQUIRE(!hull.rays.empty());
  REQUIRE(hull.face_table.faces > 0);
  const std::size_t of_lists = hull.vertices.size() * sizeof(Vec3) + hull.faces.size() * sizeof(Hull::Face) +
                               (hull.loop.size() + hull.neighbours.size()) * sizeof(std::uint32_t) +
                               hull.edges.size() * sizeof(Hull::Edge) + hull.support.memory();
  const std::size_t of_tables = hull.rays.memory() + hull.face_table.planes.size() * sizeof(float);
  CHECK(hull.rays.memory() >= 384 * sizeof(RayMap::Corners));
  CHECK(hull.memory() >= sizeof(Hull) + of_lists + of_tables);
}

TEST_CASE("meshes: every triangle is in one leaf, within its box and its slab") {
  for (const Mesh& input : {torus(1, 0.4, 40, 20), box_mesh({1, 2, 1e-9}, 12), torus(1e6, 1, 64, 3)}) {
    const MeshModel mesh = build_mesh(input);
    std::vector<int> seen(mesh.triangles.size());
    for (const std::uint32_t t : mesh.order) ++seen[t];
    CHECK(std::count(seen.begin(), seen.end(), 1) == static_cast<std::ptrdiff_t>(seen.size()));
    const std::function<void(std::uint32_t, std::vector<std::uint32_t>&)> gather = [&](std::uint32_t node, auto& out) {
      const MeshNode& n = mesh.nodes[node];
      LaneBoxes room;
      const LaneBoxes& boxes = mesh.lane_boxes(n, room);
      for (std::uint32_t k = 0; k < n.lanes(); ++k) {
        std::vector<std::uint32_t> below;
        if (n.bottom())
          below.push_back(mesh.triangle_of(n, k));
        else
          gather(mesh.boxes_of(n).child[k], below);
        for (const std::uint32_t t : below)
          for (const Vec3& corner : mesh.corners(t)) {
            const Vec3 p = (corner - mesh.centre) / mesh.unit;
            for (int i = 0; i < 3; ++i) CHECK(std::abs(p[i] - boxes.mid[i][k]) <= boxes.half[i][k]);
            if (n.bottom()) continue;
            const ChildSlabs& s = mesh.slabs[n.block];
            const double height = s.normal[0][k] * p[0] + s.normal[1][k] * p[1] + s.normal[2][k] * p[2];
            CHECK(std::abs(height - s.mid[k]) <= s.half[k]);
          }
        out.insert(out.end(), below.begin(), below.end());
      }
    };
    std::vector<std::uint32_t> all;
    gather(0, all);
    CHECK(all.size() == mesh.triangles.size());
  }
}

TEST_CASE("vertices that lie apart by less than numbers can tell are refused, also where their squares underflow") {
  for (const double size : {1e-31, 1e-100, 1e-170, 1e-300, 5e-324}) {
    CAPTURE(size);
    const std::vector<Vec3> corners{{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
    CHECK_THROWS_AS(Shape(Convex{corners}), std::invalid_argument);
    CHECK_THROWS_AS(Shape(Triangle{{corners[0], corners[1], corners[2]}}), std::invalid_argument);
    CHECK_THROWS_AS(Shape(Mesh{corners, {{0, 1, 2}, {0, 3, 1}}, false}), std::invalid_argument);
  }
  const std::vector<Vec3> point(4, Vec3(1, 2, 3));
  CHECK_NOTHROW(Shape(Convex{point}));
  CHECK_NOTHROW(Shape(Mesh{point, {{0, 1, 2}}, false}));
}

TEST_CASE("a convex shape made of another one's vertices is the same one, face by face") {
  std::mt19937_64 random(11);
  int with_inner_points = 0;
  for (int k = 0; k < 300; ++k) {
    std::vector<Vec3> points;
    std::normal_distribution<double> number;
    for (int i = 0; i < 4 + k % 20; ++i) points.push_back(Vec3{number(random), number(random), number(random)});
    const Shape first(Convex{points});
    const auto& hull = detail::ShapeInsides::hull(first);
    with_inner_points += hull.vertices.size() < points.size();
    const Shape again(Convex{hull.vertices});
    const auto& same = detail::ShapeInsides::hull(again);
    REQUIRE(same.vertices == hull.vertices);
    REQUIRE(same.loop == hull.loop);
    REQUIRE(same.faces.size() == hull.faces.size());
    for (std::size_t f = 0; f < hull.faces.size(); ++f) REQUIRE(same.faces[f].normal == hull.faces[f].normal);
  }
  CHECK(with_inner_points > 100);
}
