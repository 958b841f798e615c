// Deforming meshes answer like meshes built anew, and shapes handed out before do not change.
#include "tandem/narrowphase/deformable_mesh.h"
#include "part_runners.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <thread>
#include <tuple>

#include "catch.h"
#include "mesh_samples.h"
#include "meshes/edges_met.h"
#include "meshes/mesh_pair.h"
#include "shapes/shape_insides.h"
#include "sheet_mesh.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "triangles/predicates.h"

namespace tandem {
namespace {

using test::random_point;
using test::random_turn;
using test::torus;

// A square of side 2 of n x n cells, each two triangles.
Mesh sheet(int n) {
  return test::sheet(n, [](double x, double y) { return Vec3(x, y, 0); });
}

// Waves of random directions, lengths and heights.
class Bending {
 public:
  explicit Bending(std::mt19937_64& random, double strength = 1) {
    std::uniform_real_distribution<double> any(-1, 1);
    for (Wave& w : waves_) {
      w.along = random_point(random, 3);
      w.by = strength * random_point(random, 0.2);
      w.phase = 3 * any(random);
    }
  }
  Vec3 operator()(const Vec3& p) const {
    Vec3 q = p;
    for (const Wave& w : waves_) q += w.by * std::sin(w.along.dot(p) + w.phase);
    return q;
  }
  std::vector<Vec3> operator()(std::span<const Vec3> points) const {
    std::vector<Vec3> moved;
    for (const Vec3& p : points) moved.push_back((*this)(p));
    return moved;
  }

 private:
  struct Wave {
    Vec3 along, by;
    double phase;
  };
  std::array<Wave, 4> waves_;
};

const PartRunner on_threads = [](std::size_t parts, const std::function<void(std::size_t)>& part) {
  std::vector<std::thread> threads;
  for (std::size_t first = 0; first < 3; ++first)
    threads.emplace_back([=, &part] {
      for (std::size_t k = first; k < parts; k += 3) part(k);
    });
  for (std::thread& thread : threads) thread.join();
};

std::vector<Shape> partner_shapes() {
  return {Sphere{0.4},
          Box{{0.5, 0.6, 0.7}},
          Capsule{0.2, 0.8},
          Cylinder{0.3, 0.7},
          Cone{0.4, 0.8},
          Ellipsoid{{0.3, 0.4, 0.6}},
          HalfSpace{{0.2, 0.1, 1}, -0.3},
          Shape(Convex{{{0, 0, 0.5}, {0.5, 0, -0.3}, {-0.3, 0.4, -0.3}, {-0.3, -0.4, -0.2}, {0.1, 0.1, 0.6}}}),
          Triangle{{{{-0.6, -0.5, 0.1}, {0.7, -0.3, 0}, {0.1, 0.6, -0.2}}}},
          Shape(torus(0.5, 0.2, 18, 12)),
          Shape(Box{{0.5, 0.4, 0.3}}).rounded(0.05)};
}

// Compares two answers. Depths that are not known to be the least are both right within their bounds: which one is
// found depends on the order of triangles; false for these.
bool check_alike(const PairAnswer& bent, const PairAnswer& anew, bool all) {
  CHECK(bent.collide == anew.collide);
  if (!all) return true;
  constexpr double close = 1e-12;
  if (bent.status == Status::inexact || anew.status == Status::inexact) {
    CHECK(bent.signed_distance <= anew.signed_distance + anew.error_bound + close);
    CHECK(anew.signed_distance <= bent.signed_distance + bent.error_bound + close);
    return false;
  }
  CHECK(std::abs(bent.signed_distance - anew.signed_distance) <= close);
  CHECK((bent.point_a - anew.point_a).norm() <= 1e-9);
  CHECK((bent.point_b - anew.point_b).norm() <= 1e-9);
  CHECK((bent.normal - anew.normal).norm() <= 1e-9);
  CHECK(bent.status == anew.status);
  CHECK(std::abs(bent.error_bound - anew.error_bound) <= close);
  return true;
}

// Every request for two shapes with a partner in a pose.
void check_answers(const Shape& bent, const Shape& anew, const Shape& partner, const Pose& pose) {
  const NarrowPhase narrow;
  const Pose at{};
  INFO("partner " << name(partner.kind()) << " at " << pose.translation.transpose());
  check_alike(narrow.solve(bent, at, partner, pose, Request::collide),
              narrow.solve(anew, at, partner, pose, Request::collide), false);
  check_alike(narrow.solve(bent, at, partner, pose, Request::distance),
              narrow.solve(anew, at, partner, pose, Request::distance), true);
  std::vector<Contact> of_bent, of_anew;
  const PairAnswer first = narrow.solve(bent, at, partner, pose, Request::contacts, &of_bent);
  const PairAnswer second = narrow.solve(anew, at, partner, pose, Request::contacts, &of_anew);
  // For separated ones it is a bound.
  if (!check_alike(first, second, !of_anew.empty())) return;
  REQUIRE(of_bent.size() == of_anew.size());
  for (std::size_t k = 0; k < of_bent.size(); ++k) {
    CHECK((of_bent[k].point - of_anew[k].point).norm() <= 1e-9);
    CHECK((of_bent[k].normal - of_anew[k].normal).norm() <= 1e-9);
    CHECK(std::abs(of_bent[k].depth - of_anew[k].depth) <= 1e-12);
    CHECK(of_bent[k].feature == of_anew[k].feature);
  }
  if (partner.kind() == ShapeKind::mesh || partner.kind() == ShapeKind::triangle)
    CHECK(mesh_triangle_pairs(bent, at, partner, pose, {}) == mesh_triangle_pairs(anew, at, partner, pose, {}));
}

// Checks that all triangles are in the boxes and slabs above them.
void check_hierarchy(const MeshModel& mesh) {
  const std::function<std::vector<std::uint32_t>(std::uint32_t)> check = [&](std::uint32_t at) {
    const MeshNode& node = mesh.nodes[at];
    std::vector<std::uint32_t> all;
    std::size_t outside = 0;
    LaneBoxes room;
    const LaneBoxes& boxes = mesh.lane_boxes(node, room);
    for (std::uint32_t k = 0; k < node.lanes(); ++k) {
      const auto below =
          node.bottom() ? std::vector<std::uint32_t>{mesh.triangle_of(node, k)} : check(mesh.boxes_of(node).child[k]);
      for (const std::uint32_t t : below)
        for (const Vec3& corner : mesh.corners(t)) {
          const Vec3 p = (corner - mesh.centre) / mesh.unit;
          for (int i = 0; i < 3; ++i) {
            outside += std::abs(p[i] - boxes.mid[i][k]) <= boxes.half[i][k] ? 0 : 1;
            outside += std::abs(p[i] - node.box_mid[i]) <= node.box_half[i] ? 0 : 1;
          }
          if (node.bottom()) continue;
          const ChildSlabs& s = mesh.slabs[node.block];
          const double height = s.normal[0][k] * p[0] + s.normal[1][k] * p[1] + s.normal[2][k] * p[2];
          outside += std::abs(height - s.mid[k]) <= s.half[k] ? 0 : 1;
        }
      all.insert(all.end(), below.begin(), below.end());
    }
    CHECK(outside == 0);
    return all;
  };
  auto seen = check(0);
  std::sort(seen.begin(), seen.end());
  REQUIRE(seen.size() == mesh.triangles.size());
  for (std::uint32_t t = 0; t < seen.size(); ++t) CHECK(seen[t] == t);
}

}  // namespace

TEST_CASE("deformable meshes: bent at random, all answers are those of a shape built anew") {
  std::mt19937_64 random(7);
  Mesh open_torus = torus(0.8, 0.3, 24, 12);
  open_torus.solid = false;
  for (const Mesh& input : {sheet(14), open_torus, torus(0.8, 0.3, 24, 12), test::box_mesh({1, 1, 1}, 3)}) {
    DeformableMesh mesh(input);
    for (int round = 0; round < 6; ++round) {
      Mesh bent = input;
      bent.vertices = Bending(random, round == 0 ? 0 : 1)(input.vertices);
      mesh.update(bent.vertices);
      const Shape now = mesh.shape(), anew(bent);
      CHECK(std::ranges::equal(now.triangles(), anew.triangles()));
      CHECK(now.is_solid() == anew.is_solid());
      CHECK(now.size() == anew.size());
      CHECK(now.mass().volume == anew.mass().volume);
      for (const Shape& partner : partner_shapes()) {
        const Pose pose{random_turn(random).toRotationMatrix(), random_point(random, 1.3)};
        check_answers(now, anew, partner, pose);
        const Bounds box = now.bounds(pose), other = anew.bounds(pose);
        CHECK((box.lo - other.lo).norm() + (box.hi - other.hi).norm() <= 1e-11);
      }
    }
  }
}

TEST_CASE("deformable meshes: boxes and slabs hold their triangles, on any number of threads the same bits") {
  std::mt19937_64 random(8);
  const Mesh input = sheet(60);
  DeformableMesh alone(input), reversed(input, backwards), threaded(input, on_threads);
  std::size_t rebuilt = 0;
  for (int round = 0; round < 8; ++round) {
    const std::vector<Vec3> vertices = Bending(random, 0.5 * round)(input.vertices);
    const DeformReport report = alone.update(vertices);
    CHECK(reversed.update(vertices, backwards).rebuilt_triangles == report.rebuilt_triangles);
    CHECK(threaded.update(vertices, on_threads).worn == report.worn);
    rebuilt += report.rebuilt_triangles;
    const Shape of_alone = alone.shape(), of_reversed = reversed.shape(), of_threaded = threaded.shape();
    const MeshModel &first = mesh_of(of_alone), &second = mesh_of(of_reversed), &third = mesh_of(of_threaded);
    check_hierarchy(first);
    for (const MeshModel* other : {&second, &third}) {
      REQUIRE(other->nodes.size() == first.nodes.size());
      CHECK(std::memcmp(other->nodes.data(), first.nodes.data(), first.nodes.size() * sizeof(MeshNode)) == 0);
      CHECK(std::memcmp(other->boxes.data(), first.boxes.data(), first.boxes.size() * sizeof(ChildBoxes)) == 0);
      CHECK(std::memcmp(other->blocks.data(), first.blocks.data(), first.blocks.size() * sizeof(TriangleBlock)) == 0);
      CHECK(std::memcmp(other->slabs.data(), first.slabs.data(), first.slabs.size() * sizeof(ChildSlabs)) == 0);
      CHECK(other->order == first.order);
    }
  }
  CHECK(rebuilt > 0);
  CHECK(alone.memory() < 600 * input.triangles.size());  // two buffers
}

TEST_CASE("deformable meshes: subtrees that refits have made slow are built anew, those that bend little are not") {
  // Triangles that are not connected.
  Mesh input;
  const Mesh flat = sheet(70);
  for (const auto& t : flat.triangles) {
    const Vec3 middle = (flat.vertices[t[0]] + flat.vertices[t[1]] + flat.vertices[t[2]]) / 3;
    for (const std::uint32_t v : t) input.vertices.push_back(flat.vertices[v] + 0.1 * (middle - flat.vertices[v]));
    const auto at = static_cast<std::uint32_t>(input.vertices.size());
    input.triangles.push_back({at - 3, at - 2, at - 1});
  }
  DeformableMesh mesh(input);
  std::vector<Vec3> vertices = input.vertices;
  for (Vec3& v : vertices) v *= 3;  // scaled alike: nothing is worn
  CHECK(mesh.update(vertices).rebuilt_triangles == 0);
  // Disturbed in one corner.
  std::mt19937_64 random(9);
  for (std::size_t v = 0; v < vertices.size(); v += 3) {
    if (!(vertices[v].x() > 2.2 && vertices[v].y() > 2.2)) continue;
    const Vec3 by = Vec3(2.6, 2.6, 0) + random_point(random, 0.4) - vertices[v];
    for (std::size_t k = 0; k < 3; ++k) vertices[v + k] += by;
  }
  const DeformReport report = mesh.update(vertices);
  CHECK(report.worn > 1.5);
  CHECK(report.rebuilt_triangles > 100);
  CHECK(report.rebuilt_triangles < input.triangles.size() / 2);
  check_hierarchy(mesh_of(mesh.shape()));
  CHECK(mesh.update(vertices).rebuilt_triangles == 0);
}

TEST_CASE("deformable meshes: a shape that was handed out stays as it is") {
  const Mesh input = sheet(12);
  DeformableMesh mesh(input);
  const Shape before = mesh.shape();
  const Shape rounded = before.rounded(0.1);
  std::vector<Vec3> up = input.vertices;
  for (Vec3& v : up) v.z() += 1;
  std::vector<Shape> held;
  for (int k = 0; k < 4; ++k) {
    for (Vec3& v : up) v.z() += 1;
    mesh.update(up);
    held.push_back(mesh.shape());
  }
  const NarrowPhase narrow;
  const auto height = [&](const Shape& shape) {
    return narrow.solve(Sphere{0}, Pose::at(0, 0, 20), shape, Pose{}, Request::distance).signed_distance;
  };
  CHECK(height(before) == Approx(20));
  CHECK(height(rounded) == Approx(19.9));
  for (int k = 0; k < 4; ++k) CHECK(height(held[static_cast<std::size_t>(k)]) == Approx(18 - k));
  // If nobody holds a shape, memory does not grow.
  held.clear();
  mesh.update(up);
  const std::size_t bytes = mesh.memory();
  for (int k = 0; k < 5; ++k) mesh.update(up);
  CHECK(mesh.memory() <= bytes);
}

TEST_CASE("deformable meshes: what is refused, and that nothing has changed then") {
  const auto refuses = [](DeformableMesh& mesh, const std::vector<Vec3>& vertices, const std::string& why) {
    const std::vector<Vec3> before(mesh.vertices().begin(), mesh.vertices().end());
    try {
      mesh.update(vertices);
      FAIL("not refused");
    } catch (const std::invalid_argument& error) {
      CHECK_THAT(error.what(), Catch::Contains(why));
    }
    CHECK(std::ranges::equal(before, mesh.vertices()));
  };
  DeformableMesh cloth(sheet(3));
  std::vector<Vec3> vertices = sheet(3).vertices;
  vertices[5].y() = std::nan("");
  refuses(cloth, vertices, "vertices[5]");
  vertices[5].y() = 2e30;
  refuses(cloth, vertices, "1e30");
  vertices.pop_back();
  refuses(cloth, vertices, "holds 15; it must hold 16");

  Mesh box = test::box_mesh({1, 1, 1}, 2);  // with duplicate vertices
  DeformableMesh solid(box);
  box.vertices[0].x() += 0.1;
  refuses(solid, box.vertices, "they were one");
  box = test::box_mesh({1, 1, 1}, 2);
  for (Vec3& v : box.vertices) v.x() = -v.x();
  refuses(solid, box.vertices, "inside out");
  CHECK_THROWS_AS(DeformableMesh(Mesh{{{0, 0, 0}}, {{0, 0, 1}}, false}), std::invalid_argument);
}

TEST_CASE("deformable meshes: an update that shrinks to nothing or whose helpers fail leaves a mesh that answers") {
  Mesh flat = sheet(3);
  DeformableMesh cloth(flat);
  for (const double size : {1e-31, 1e-170, 1e-300}) {
    std::vector<Vec3> vertices = flat.vertices;
    for (Vec3& v : vertices) v *= size;
    CHECK_THROWS_AS(cloth.update(vertices), std::invalid_argument);
    CHECK(std::ranges::equal(cloth.vertices(), flat.vertices));
    CHECK(cloth.shape().size() > 1);
  }
  // Each call of the runner fails once, with a shape handed out and without.
  for (const bool is_held : {false, true}) {
    int failing = 0;
    for (bool failed = true; failed; ++failing) {
      CAPTURE(is_held, failing);
      DeformableMesh mesh(sheet(150));  // two ranges of vertices
      std::optional<Shape> held;
      if (is_held) held = mesh.shape();
      std::vector<Vec3> vertices(mesh.vertices().begin(), mesh.vertices().end());
      const std::vector<Vec3> before = vertices;
      for (Vec3& v : vertices) v.z() += 2;
      int calls = 0;
      const auto parts = [&](std::size_t count, const std::function<void(std::size_t)>& part) {
        if (calls++ == failing) throw std::runtime_error("a helper failed");
        for (std::size_t i = 0; i < count; ++i) part(i);
      };
      failed = false;
      try {
        mesh.update(vertices, parts);
      } catch (const std::runtime_error&) {
        failed = true;
      }
      const bool is_new = std::ranges::equal(mesh.vertices(), vertices);
      CHECK((is_new || (failed && std::ranges::equal(mesh.vertices(), before))));
      CHECK(mesh.shape().bounds(Pose{}).hi.z() == (is_new ? 2 : 0));
      CHECK(mesh.shape().bounds(Pose{}).lo.z() == (is_new ? 2 : 0));
      mesh.update(before);
      CHECK(mesh.shape().bounds(Pose{}).hi.z() == 0);
    }
    CHECK(failing > 3);
  }
}

TEST_CASE("deformable meshes: turned inside out and refused, the mesh answers as before") {
  const auto with_size = [](const Vec3& size) {
    std::vector<Vec3> vertices = test::box_mesh({1, 1, 1}, 3).vertices;
    for (Vec3& v : vertices) v = v.cwiseProduct(size);
    return vertices;
  };
  const auto triangles_met = [](const Shape& shape) {
    const Shape ball(Mesh{test::box_mesh({0.3, 0.3, 0.3}, 1)});
    return mesh_triangle_pairs(shape, Pose{}, ball, Pose::at(1, 0.1, 0.2), {});
  };
  DeformableMesh mesh(test::box_mesh({1, 1, 1}, 3));
  // In the memory of the last update, of a new one and of the one before.
  std::optional<Shape> held;
  for (const double width : {1.2, 1.3, 1.4, 1.5}) {
    const Vec3 size(2, width, 1);
    mesh.update(with_size(size));
    if (width > 1.2) held = mesh.shape();
    const auto before = triangles_met(mesh.shape());
    CHECK(!before.empty());
    // For a thin one, floats cannot give the sign of the volume.
    for (const double thickness : {1.0, 1e-9}) {
      CHECK_THROWS_AS(mesh.update(with_size({3, -1, thickness})), std::invalid_argument);
      CHECK(std::ranges::equal(mesh.vertices(), with_size(size)));
      CHECK(triangles_met(mesh.shape()) == before);
      CHECK(mesh.shape().bounds(Pose{}).hi.isApprox(size / 2));
    }
    if (held) CHECK(triangles_met(*held) == before);
    mesh.update(with_size({3, 1, 1e-9}));
    CHECK(triangles_met(mesh.shape()) != before);
  }
}

TEST_CASE("deformable meshes: pairs of triangles that share no vertex and meet, as every pair by itself says") {
  std::mt19937_64 random(10);
  const Mesh input = sheet(16);
  DeformableMesh mesh(input);
  std::size_t found = 0;
  for (int round = 0; round < 6; ++round) {
    std::vector<Vec3> vertices = Bending(random, 3)(input.vertices);
    if (round == 4)  // folded flat onto itself
      for (std::size_t v = 0; v < vertices.size(); ++v)
        vertices[v] = {std::abs(input.vertices[v].x()), input.vertices[v].y(), 0};
    mesh.update(vertices);
    const Shape held = mesh.shape();
    const MeshModel& model = mesh_of(held);
    TriangleTest test(Pose{}, Pose{}, 10);
    std::vector<std::array<std::uint32_t, 2>> expected;
    for (std::uint32_t i = 0; i < input.triangles.size(); ++i)
      for (std::uint32_t j = i + 1; j < input.triangles.size(); ++j) {
        const auto &p = input.triangles[i], &q = input.triangles[j];
        if (std::find_first_of(p.begin(), p.end(), q.begin(), q.end()) != p.end()) continue;
        const auto a = model.corners(i), b = model.corners(j);
        const auto apart = [&](int axis) {
          const auto [l, h] = std::minmax({a[0][axis], a[1][axis], a[2][axis]});
          const auto [m, n] = std::minmax({b[0][axis], b[1][axis], b[2][axis]});
          return h < m || n < l;
        };
        if (!apart(0) && !apart(1) && !apart(2) && test.exact(a, b)) expected.push_back({i, j});
      }
    found += expected.size();
    CHECK(mesh.self_intersections() == expected);
    CHECK(mesh.self_intersections(on_threads) == expected);
  }
  CHECK(found > 1000);
}

namespace {

// By the narrow phase, which does not use the functions under test.
double distance_of(const Shape& a, const Shape& b) {
  return std::max(0.0, NarrowPhase().solve(a, Pose{}, b, Pose{}, Request::distance).signed_distance);
}

using Edge = std::array<std::uint32_t, 2>;
std::vector<Edge> edges_of(const Mesh& mesh) {
  std::vector<Edge> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      edges.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// Pairs between these bounds may be reported or not: rounding decides.
struct Expected {
  std::size_t surely = 0;
  void add(double distance, double margin, bool told) {
    const bool near = distance<margin*(1 - 1e-6), far = distance> margin * (1 + 1e-6);
    if (near) CHECK(told);
    if (far) CHECK_FALSE(told);
    surely += near ? 1 : 0;
  }
};

// Every vertex with every triangle, every edge with every edge.
void check_near(const NearFeatures& found, const std::vector<NearPoint>& points, const Mesh& a, const Mesh& b,
                bool self, bool edges_too, double margin) {
  Expected expected;
  const auto told_point = [&](std::uint32_t v, std::uint32_t t) {
    const auto at =
        std::lower_bound(points.begin(), points.end(), std::pair(v, t),
                         [](const NearPoint& x, const auto& y) { return std::pair(x.vertex, x.triangle) < y; });
    return at != points.end() && at->vertex == v && at->triangle == t ? &*at : nullptr;
  };
  std::vector<Shape> of_b;
  for (const auto& t : b.triangles)
    of_b.emplace_back(Triangle{{{b.vertices[t[0]], b.vertices[t[1]], b.vertices[t[2]]}}});
  for (std::uint32_t v = 0; v < a.vertices.size(); ++v)
    for (std::uint32_t t = 0; t < b.triangles.size(); ++t) {
      const auto& c = b.triangles[t];
      const NearPoint* told = told_point(v, t);
      if (self && std::find(c.begin(), c.end(), v) != c.end()) {
        CHECK(told == nullptr);
        continue;
      }
      const Vec3 &x = a.vertices[v], &p = b.vertices[c[0]], &q = b.vertices[c[1]], &r = b.vertices[c[2]];
      if ((x - p).norm() - (q - p).norm() - (r - p).norm() > margin) {
        CHECK(told == nullptr);
        continue;
      }
      const double d = NarrowPhase()
                           .solve(Sphere{0}, Pose::at(x.x(), x.y(), x.z()), of_b[t], Pose{}, Request::distance)
                           .signed_distance;
      expected.add(d, margin, told != nullptr);
      if (told != nullptr) CHECK(std::abs(told->distance - d) <= 1e-7);
    }
  CHECK(points.size() >= expected.surely);
  CHECK(expected.surely > 0);
  if (!edges_too) return;
  Expected of_edges;
  const std::vector<Edge> all_a = edges_of(a), all_b = edges_of(b);
  std::size_t at = 0;
  const auto segments = [](const Mesh& mesh, const std::vector<Edge>& edges) {
    std::vector<Shape> shapes;
    for (const auto& [p, q] : edges)
      shapes.emplace_back(Triangle{{{mesh.vertices[p], mesh.vertices[q], mesh.vertices[q]}}});
    return shapes;
  };
  const std::vector<Shape> segments_a = segments(a, all_a), segments_b = segments(b, all_b);
  for (std::size_t i = 0; i < all_a.size(); ++i)
    for (std::size_t j = 0; j < all_b.size(); ++j) {
      const Edge &e = all_a[i], &f = all_b[j];
      if (self && (!(e < f) || e[0] == f[0] || e[0] == f[1] || e[1] == f[0] || e[1] == f[1])) continue;
      const bool told = at < found.edges.size() && found.edges[at].a == e && found.edges[at].b == f;
      const Vec3 &p = a.vertices[e[0]], &q = a.vertices[e[1]], &r = b.vertices[f[0]], &s = b.vertices[f[1]];
      if ((p - r).norm() - (q - p).norm() - (s - r).norm() > margin) {
        CHECK_FALSE(told);
        continue;
      }
      const double d = distance_of(segments_a[i], segments_b[j]);
      of_edges.add(d, margin, told);
      if (told) CHECK(std::abs(found.edges[at].distance - d) <= 1e-7);
      at += told ? 1 : 0;
    }
  CHECK(at == found.edges.size());
  CHECK(of_edges.surely > 0);
}

}  // namespace

TEST_CASE("near features: of a mesh with itself and of two, as every pair by itself says") {
  std::mt19937_64 random(11);
  const Mesh input = sheet(9);
  DeformableMesh mesh(input);
  for (const double margin : {0.17, 0.3}) {
    Mesh bent = input;
    bent.vertices = Bending(random, 2.5)(input.vertices);
    mesh.update(bent.vertices);
    const NearFeatures own = mesh.near_features(margin);
    check_near(own, own.points, bent, bent, true, true, margin);
    const NearFeatures threaded = mesh.near_features(margin, on_threads);
    CHECK(threaded.points.size() == own.points.size());
    CHECK(threaded.edges.size() == own.edges.size());

    const Mesh ring = torus(0.7, 0.25, 12, 8);
    const Pose pose{random_turn(random).toRotationMatrix(), random_point(random, 0.3)};
    const Pose about{random_turn(random).toRotationMatrix(), random_point(random, 5)};
    const Pose at_b{about.rotation * pose.rotation, about * pose.translation};
    const NearFeatures both = near_features(mesh.shape(), about, Shape(ring), at_b, margin);
    Mesh placed = ring;
    for (Vec3& v : placed.vertices) v = pose * v;
    check_near(both, both.points, bent, placed, false, true, margin);
    check_near(both, both.points_of_b, placed, bent, false, false, margin);
  }
  CHECK_THROWS_AS(mesh.near_features(-1), std::invalid_argument);
  CHECK_THROWS_AS(mesh.visit_near_features(-1, {}), std::invalid_argument);
  CHECK_THROWS_AS(visit_near_features(Sphere{1}, Pose{}, mesh.shape(), Pose{}, 0.1, {}), std::invalid_argument);
  CHECK_THROWS_AS(near_features(Sphere{1}, Pose{}, mesh.shape(), Pose{}, 0.1), std::invalid_argument);
}

namespace {

/// The results of a search, and the condition that ends it.
struct Told {
  NearFeatures features;
  std::vector<std::array<std::uint32_t, 2>> pairs;
  std::vector<double> progress;
  std::size_t most = std::numeric_limits<std::size_t>::max();  ///< number after which the visitor ends the search
  std::size_t looks = 0, most_looks = std::numeric_limits<std::size_t>::max();
  WorkLimit limit{.ended = [this] { return ++looks > most_looks; }};

  std::size_t count() const {
    return features.points.size() + features.points_of_b.size() + features.edges.size() + pairs.size();
  }
  SearchOptions options() {
    return {.limit = &limit, .progress = [this](double part) { progress.push_back(part); }};
  }
  NearFeatureVisitor features_visitor() {
    return {[this](const NearPoint& p) { return features.points.push_back(p), count() < most; },
            [this](const NearPoint& p) { return features.points_of_b.push_back(p), count() < most; },
            [this](const NearEdges& e) { return features.edges.push_back(e), count() < most; }};
  }
};

using Search = std::function<SearchEnd(Told&)>;

/// Searches to the end, to the first results, and until the limit is reached at some check.
void check_search(const Search& search, std::size_t all, const std::function<void(Told&)>& check_all) {
  Told whole;
  REQUIRE(search(whole) == SearchEnd::done);
  CHECK(whole.count() == all);
  check_all(whole);
  REQUIRE(!whole.progress.empty());
  CHECK(std::is_sorted(whole.progress.begin(), whole.progress.end()));
  CHECK(whole.progress.front() > 0);
  CHECK(whole.progress.back() == 1);
  CHECK(whole.progress.size() > 20);
  CHECK(whole.progress.size() <= 100);
  // A check comes every 30 us of work, in which at most some hundred pairs are found.
  CHECK(whole.looks > 20);
  CHECK(whole.looks * 300 > all);

  Told few;
  few.most = 7;
  CHECK(search(few) == SearchEnd::by_visitor);
  CHECK(few.count() == 7);
  CHECK((few.progress.empty() || few.progress.back() < 1));

  for (const std::size_t looks : {std::size_t{0}, whole.looks / 2, whole.looks - 1}) {
    Told stopped;
    stopped.most_looks = looks;
    CHECK(search(stopped) == SearchEnd::stopped);
    CHECK(stopped.looks == looks + 1);  // no work is done after it
    CHECK(stopped.count() <= all);
    CHECK((stopped.progress.empty() || stopped.progress.back() < 1));
  }
}

}  // namespace

TEST_CASE("searches of a mesh with itself tell what the lists have, each once, and end when they are told to") {
  std::mt19937_64 random(12);
  const Mesh input = sheet(60);
  DeformableMesh mesh(input);
  std::vector<Vec3> folded;  // its halves cross each other's waves
  for (const Vec3& v : input.vertices)
    folded.emplace_back(std::abs(v.x()), v.y(), (v.x() > 0 ? 0.05 : -0.05) * std::sin(20 * v.y() + v.x()));
  mesh.update(folded);
  constexpr double margin = 0.03;
  const auto same_features = [](Told& told, const NearFeatures& list) {
    const auto of_point = [](const NearPoint& p) { return std::tuple(p.vertex, p.triangle, p.distance); };
    const auto of_edges = [](const NearEdges& e) { return std::tuple(e.a, e.b, e.distance); };
    std::ranges::sort(told.features.points, {}, of_point);
    std::ranges::sort(told.features.points_of_b, {}, of_point);
    std::ranges::sort(told.features.edges, {}, of_edges);
    CHECK(std::ranges::equal(told.features.points, list.points, {}, of_point, of_point));
    CHECK(std::ranges::equal(told.features.points_of_b, list.points_of_b, {}, of_point, of_point));
    CHECK(std::ranges::equal(told.features.edges, list.edges, {}, of_edges, of_edges));
  };

  const auto pairs = mesh.self_intersections();
  REQUIRE(pairs.size() > 100);
  const auto visit_pairs = [&](Told& told) {
    const auto take = [&](const std::array<std::uint32_t, 2>& pair) {
      told.pairs.push_back(pair);
      return told.count() < told.most;
    };
    return mesh.visit_self_intersections(take, told.options());
  };
  check_search(visit_pairs, pairs.size(), [&](Told& told) {
    std::ranges::sort(told.pairs);
    CHECK(told.pairs == pairs);
  });

  const NearFeatures own = mesh.near_features(margin);
  REQUIRE(own.points.size() > 100);
  check_search([&](Told& told) { return mesh.visit_near_features(margin, told.features_visitor(), told.options()); },
               own.points.size() + own.edges.size(), [&](Told& told) { same_features(told, own); });

  const Shape now = mesh.shape(), ring(torus(0.7, 0.25, 60, 40));
  const Pose pose{random_turn(random).toRotationMatrix(), random_point(random, 0.1)};
  const NearFeatures both = near_features(now, {}, ring, pose, margin);
  REQUIRE(both.points_of_b.size() > 100);
  const auto visit_both = [&](Told& told) {
    return visit_near_features(now, {}, ring, pose, margin, told.features_visitor(), told.options());
  };
  check_search(visit_both, both.points.size() + both.points_of_b.size() + both.edges.size(),
               [&](Told& told) { same_features(told, both); });
}

TEST_CASE("near features: an edge that more than two triangles share is told once") {
  // Three triangles at one edge, beside a fourth.
  const Mesh wings{
      {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {-1, 1, 0}, {-1, -1, 0}, {0.05, 0.3, 0.4}, {0.05, 0.3, 0.6}, {2, 2, 2}},
      {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {5, 6, 7}}};
  const DeformableMesh mesh(wings);
  std::size_t list = 0, told = 0;
  for (const NearEdges& e : mesh.near_features(0.35).edges)
    list += e.a == std::array{0u, 1u} && e.b == std::array{5u, 6u};
  const auto take = [&](const NearEdges& e) {
    told += e.a == std::array{0u, 1u} && e.b == std::array{5u, 6u};
    return true;
  };
  CHECK(mesh.visit_near_features(0.35, {.edges = take}) == SearchEnd::done);
  CHECK(list == 1);
  CHECK(told == 1);
}

TEST_CASE("near features: of edges that coincide with other numbers of vertices both are reported") {
  // Two triangles with vertices of their own, beside each other along a side from (0, 0, 0) to (1, 0, 0).
  const Mesh pieces{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {3, 4, 5}}, false};
  const Shape sheet{pieces}, above = Triangle{{Vec3(0.5, 0, 0.1), Vec3(0.5, 0, 2), Vec3(0.5, 1, 2)}};
  const NearFeatures near = near_features(sheet, {}, above, {}, 0.15);
  std::vector<std::array<std::uint32_t, 2>> edges;
  for (const NearEdges& pair : near.edges)
    if (pair.b == std::array<std::uint32_t, 2>{0, 1}) edges.push_back(pair.a);
  CHECK(edges == std::vector<std::array<std::uint32_t, 2>>{{0, 1}, {3, 4}});
  // Of a mesh with itself coincident vertices, and so these edges, are one.
  const NearFeatures own = DeformableMesh(pieces).near_features(2);
  for (const NearEdges& pair : own.edges) CHECK(pair.b[1] != 3);
  CHECK(own.edges.size() == 2);
}

}  // namespace tandem

TEST_CASE("edges are met once, and looked for among few, also where one vertex has them all") {
  constexpr std::uint32_t count = 20000;
  for (const bool lower : {true, false}) {
    tandem::EdgesMet met(count);
    const auto edge = [&](std::uint32_t i) {
      return lower ? std::array<std::uint32_t, 2>{0, i + 1} : std::array<std::uint32_t, 2>{i, count};
    };
    for (std::uint32_t i = 0; i < count; ++i) CHECK(met.is_new(edge(i)));
    for (std::uint32_t i = 0; i < count; i += 7) CHECK(!met.is_new(edge(i)));
    CHECK(met.longest_list() < 16);
  }
}
