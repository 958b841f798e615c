// Two meshes: exact intersections, distances, depths, contacts.
#include <fcl/narrowphase/collision.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <new>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>
#include <thread>

#include "ask.h"
#include "catch.h"
#include "mesh_samples.h"
#include "meshes/mesh_pair.h"
#include "meshes/traversal/point_in_mesh.h"
#include "shapes/mesh_builder.h"
#include "shapes/shape_insides.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "triangles/predicates.h"

using namespace tandem;
using namespace tandem::test;
using Json = nlohmann::json;
using Pairs = std::vector<std::array<std::uint32_t, 2>>;

namespace {

std::vector<Contact> contacts_of(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, double margin = 0) {
  std::vector<Contact> contacts;
  NarrowPhase({.margin = margin}).solve(a, pa, b, pb, Request::contacts, &contacts);
  for (const Contact& c : contacts) {
    CHECK(c.point.allFinite());
    CHECK(c.normal.norm() == Approx(1));
    CHECK(std::isfinite(c.depth));
    CHECK(c.depth >= -margin);
  }
  return contacts;
}

// The length by which B must move along d until the two no longer touch, to 1e-12; they touch now.
double separation(const Shape& a, const Pose& pa, const Shape& b, const Pose& pb, const Vec3& d) {
  double in = 0, out = a.size() + b.size();
  for (int i = 0; i < 50; ++i) (collide(a, pa, b, moved(pb, (in + out) / 2 * d)) ? in : out) = (in + out) / 2;
  return out;
}

fcl::BVHModel<fcl::OBBRSSd> fcl_model(const Mesh& mesh) {
  std::vector<fcl::Vector3d> vertices(mesh.vertices.begin(), mesh.vertices.end());
  std::vector<fcl::Triangle> triangles;
  for (const auto& t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
  fcl::BVHModel<fcl::OBBRSSd> model;
  model.beginModel();
  model.addSubModel(vertices, triangles);
  model.endModel();
  return model;
}

fcl::Transform3d fcl_pose(const Pose& pose) {
  fcl::Transform3d t = fcl::Transform3d::Identity();
  t.linear() = pose.rotation;
  t.translation() = pose.translation;
  return t;
}

Mesh read_mesh(const std::filesystem::path& path) {
  Mesh mesh;
  std::ifstream in(path, std::ios::binary);
  REQUIRE(in);
  if (path.extension() == ".stl") {
    for (std::string word; in >> word;)
      if (word == "vertex") {
        Vec3 v;
        in >> v.x() >> v.y() >> v.z();
        mesh.vertices.push_back(v);
      }
    for (std::uint32_t i = 0; i + 2 < mesh.vertices.size(); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
    return mesh;
  }
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    if (key == "v") {
      Vec3 v;
      words >> v.x() >> v.y() >> v.z();
      mesh.vertices.push_back(v);
    } else if (key == "f") {
      std::vector<std::uint32_t> polygon;
      for (std::string word; words >> word;) polygon.push_back(static_cast<std::uint32_t>(std::stoul(word)) - 1);
      for (std::size_t i = 2; i < polygon.size(); ++i)
        mesh.triangles.push_back({polygon[0], polygon[i - 1], polygon[i]});
    }
  }
  return mesh;
}

Pose read_pose(const Json& json) {
  Pose pose;
  for (int i = 0; i < 3; ++i) {
    pose.translation[i] = json["t"][static_cast<std::size_t>(i)];
    for (int j = 0; j < 3; ++j)
      pose.rotation(i, j) = json["R"][static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
  return pose;
}

Shape read_shape(const Json& json, const std::filesystem::path& meshes) {
  if (json.contains("file")) return Shape(read_mesh(meshes / json["file"].get<std::string>()));
  Mesh mesh;
  for (const Json& v : json["vertices"]) mesh.vertices.emplace_back(v[0], v[1], v[2]);
  if (json["kind"] == "triangle") return Triangle{{mesh.vertices[0], mesh.vertices[1], mesh.vertices[2]}};
  for (const Json& t : json["triangles"]) mesh.triangles.push_back({t[0], t[1], t[2]});
  return Shape(mesh);
}

}  // namespace

TEST_CASE("all intersecting triangle pairs of two meshes are those of all against all") {
  const Mesh input_a = torus(1, 0.4, 14, 9), input_b = box_mesh(Vec3(1.3, 0.9, 1.7), 4);
  const Shape a(input_a), b(input_b);
  std::mt19937_64 random(21);
  std::size_t found = 0;
  for (int i = 0; i < 30; ++i) {
    // Every third pair in one frame: edges and faces then coincide.
    const Pose pa = i % 3 ? random_pose(random, 1) : Pose{};
    const Pose pb = i % 3 ? random_pose(random, 1) : Pose::at(0.25 * (i % 5), 0, 0);
    TriangleTest test(pa, pb, 2);
    Pairs want;
    for (std::uint32_t x = 0; x < input_a.triangles.size(); ++x)
      for (std::uint32_t y = 0; y < input_b.triangles.size(); ++y) {
        const auto p = mesh_of(a).corners(x), q = mesh_of(b).corners(y);
        if (test(p, q, {test.in_a(q[0]), test.in_a(q[1]), test.in_a(q[2])})) want.push_back({x, y});
      }
    CAPTURE(i);
    REQUIRE(mesh_triangle_pairs(a, pa, b, pb, {}) == want);
    for (auto& pair : want) std::swap(pair[0], pair[1]);
    std::sort(want.begin(), want.end());
    REQUIRE(mesh_triangle_pairs(b, pb, a, pa, {}) == want);
    found += want.size();
  }
  CHECK(found > 1000);
}

TEST_CASE("a small mesh whose corners just pierce or just miss a large one: what single precision blurs is found") {
  // Fine triangles far from the centre.
  Mesh large{{{-1, -1, -1}, {-1, -0.9, -1}, {-1, -1, -0.9}}, {{0, 1, 2}}};
  constexpr std::uint32_t row = 12;
  for (std::uint32_t x = 0; x < row; ++x)
    for (std::uint32_t y = 0; y < row; ++y) {
      large.vertices.emplace_back(1 + 1e-3 * x, 1 + 1e-3 * y, 0.7 + 3e-4 * std::sin(1.0 * x * y));
      const std::uint32_t v = 3 + x * row + y;
      if (x + 1 == row || y + 1 == row) continue;
      large.triangles.push_back({v, v + row, v + 1});
      large.triangles.push_back({v + 1, v + row, v + row + 1});
    }
  const Mesh small = box_mesh(Vec3(2e-4, 3e-4, 1e-4), 1);
  const Shape a(large), b(small);
  std::mt19937_64 random(23);
  std::size_t found = 0;
  for (std::size_t i = 0; i < 400; ++i) {
    const Pose pa = random_pose(random, 1);
    Pose pb = Pose::from(random_turn(random), Vec3::Zero());
    // A corner within some 1e-8 of the middle of a triangle, the rest of the box outside.
    const auto p = mesh_of(a).corners(static_cast<std::uint32_t>(1 + 7 * i % (large.triangles.size() - 1)));
    const Vec3 out = pa.rotation * (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    const double sink = (i % 2 != 0 ? 1 : -1) * std::pow(10.0, -8 - static_cast<double>(i % 4));
    Vec3 corner = pb.rotation * mesh_of(b).vertices[0];
    for (const Vec3& v : mesh_of(b).vertices)
      if ((pb.rotation * v).dot(out) < corner.dot(out)) corner = pb.rotation * v;
    pb.translation = pa * ((p[0] + p[1] + p[2]) / 3) - corner - sink * out;
    TriangleTest test(pa, pb, 1);
    Pairs want;
    for (std::uint32_t x = 0; x < large.triangles.size(); ++x)
      for (std::uint32_t y = 0; y < small.triangles.size(); ++y) {
        const auto t = mesh_of(a).corners(x), q = mesh_of(b).corners(y);
        if (test(t, q, {test.in_a(q[0]), test.in_a(q[1]), test.in_a(q[2])})) want.push_back({x, y});
      }
    CAPTURE(i, sink);
    REQUIRE(mesh_triangle_pairs(a, pa, b, pb, {}) == want);
    found += want.empty() ? 0 : 1;
  }
  CHECK(found >= 200);
}

TEST_CASE("stretched, tiny, far, aligned and shifted meshes: every pair that exact arithmetic finds among all") {
  Mesh ring = torus(1, 0.4, 12, 8), needle = ring, tiny = ring, flat = box_mesh(Vec3(2, 2, 1), 3);
  for (Vec3& v : needle.vertices) v.x() *= 1e4;
  for (Vec3& v : tiny.vertices) v *= 1e-4;
  flat.solid = ring.solid = needle.solid = tiny.solid = false;
  flat.triangles.push_back({0, 1, 0});
  flat.triangles.push_back({2, 2, 2});
  const std::vector<Shape> shapes{Shape(ring), Shape(needle), Shape(tiny), Shape(flat)};
  std::mt19937_64 random(27);
  std::size_t found = 0;
  for (std::size_t i = 0; i < 24; ++i) {
    const Shape &a = shapes[i % 2 ? 0 : 3], &b = shapes[i % 4];
    Pose pa, pb;
    if (i % 3) pa = random_pose(random, i % 5 == 1 ? 1e6 : 1);
    pb = pa;
    if (i % 6 == 1)
      pb = {pa.rotation * Eigen::AngleAxisd(std::numbers::pi / 6, Vec3::UnitZ()).toRotationMatrix(), pa.translation};
    if (i % 6 > 2) pb.translation += pa.rotation * mesh_of(a).vertices[5 * i % 60];
    if (i % 6 > 3) pb.rotation = random_turn(random).toRotationMatrix();
    TriangleTest test(pa, pb, 1e4);
    Pairs want;
    for (std::uint32_t x = 0; x < mesh_of(a).triangles.size(); ++x)
      for (std::uint32_t y = 0; y < mesh_of(b).triangles.size(); ++y) {
        const auto p = mesh_of(a).corners(x), q = mesh_of(b).corners(y);
        // Clearly separated: the exact answer is not needed.
        Bounds bp{p[0], p[0]}, bq{test.in_a(q[0]), test.in_a(q[0])};
        for (std::size_t k = 1; k < 3; ++k) {
          bp = {bp.lo.cwiseMin(p[k]), bp.hi.cwiseMax(p[k])};
          bq = {bq.lo.cwiseMin(test.in_a(q[k])), bq.hi.cwiseMax(test.in_a(q[k]))};
        }
        if ((bp.lo - bq.hi).cwiseMax(bq.lo - bp.hi).maxCoeff() > 1e-6) continue;
        if (test.exact(p, q)) want.push_back({x, y});
      }
    CAPTURE(i);
    REQUIRE(mesh_triangle_pairs(a, pa, b, pb, {}) == want);
    REQUIRE(NarrowPhase().solve(a, pa, b, pb, Request::collide).collide == !want.empty());
    found += want.size();
  }
  CHECK(found > 1500);
}

TEST_CASE("distance of meshes near and far is the least of all their triangles") {
  Mesh ring = torus(1, 0.4, 7, 5), sheet{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 1, 0.1)},
                                         {{0, 1, 2}, {1, 3, 2}, {0, 1, 1}, {3, 3, 3}},
                                         false};
  ring.solid = false;
  const Shape a(ring), b(sheet);
  std::mt19937_64 random(28);
  for (int i = 0; i < 24; ++i) {
    const Pose pa = random_pose(random, i % 4 == 3 ? 1e6 : 1);
    Pose pb = Pose::from(random_turn(random), pa.translation);
    const Vec3 d = random_point(random, 1).normalized();
    pb.translation += d * (i % 3 == 2 ? 500.0 : separation(a, pa, b, pb, d) + std::pow(10, -i % 12));
    if (collide(a, pa, b, pb)) continue;
    double want = 1e9;
    for (std::uint32_t x = 0; x < ring.triangles.size(); ++x)
      for (std::uint32_t y = 0; y < sheet.triangles.size(); ++y)
        want = std::min(want, NarrowPhase()
                                  .solve(Triangle{mesh_of(a).corners(x)}, pa, Triangle{mesh_of(b).corners(y)}, pb,
                                         Request::distance)
                                  .signed_distance);
    const PairAnswer r = NarrowPhase().solve(a, pa, b, pb, Request::distance);
    CAPTURE(i);
    CHECK(r.signed_distance == Approx(want).margin(1e-12));
    CHECK((r.point_b - r.point_a).norm() == Approx(r.signed_distance).margin(i % 4 == 3 ? 1e-9 : 1e-12));
  }
}

TEST_CASE("mesh verdicts agree with FCL's") {
  const Mesh mesh = torus(0.6, 0.25, 24, 24);
  const Shape shape(mesh);
  const auto model = fcl_model(mesh);
  std::mt19937_64 random(22);
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const Pose pa = random_pose(random, 0.8);
    const Pose pb = random_pose(random, 0.8);
    fcl::CollisionResultd result;
    const bool want = fcl::collide(&model, fcl_pose(pa), &model, fcl_pose(pb), fcl::CollisionRequestd(), result) > 0;
    CAPTURE(i);
    REQUIRE(collide(shape, pa, shape, pb) == want);
    hits += want;
  }
  CHECK(hits > 50);
  CHECK(hits < 250);
}

TEST_CASE("real meshes and hard triangles: every intersecting pair, exactly") {
  const char* shared = std::getenv("TANDEM_SHARED");
  if (shared == nullptr) TANDEM_SKIP("TANDEM_SHARED, a folder with cases/ and meshes/, is not set");
  const std::filesystem::path root(shared);
  int files = 0, records = 0;
  for (const auto& entry : std::filesystem::directory_iterator(root / "cases" / "mesh_pairs")) {
    const Json json = Json::parse(std::ifstream(entry.path()));
    const Pairs pairs = mesh_triangle_pairs(read_shape(json["shapeA"], root / "meshes"), read_pose(json["poseA"]),
                                            read_shape(json["shapeB"], root / "meshes"), read_pose(json["poseB"]), {});
    CAPTURE(entry.path());
    const Json& expect = json["expect"];
    CHECK(pairs.size() == expect["intersecting_pairs"].get<std::size_t>());
    const Pairs listed = expect["pairs"].get<Pairs>();
    for (const auto& pair : listed) CHECK(std::binary_search(pairs.begin(), pairs.end(), pair));
    if (!expect["truncated"].get<bool>()) CHECK(pairs.size() == listed.size());
    ++files;
  }
  CHECK(files == 8);
  std::ifstream lines(root / "cases" / "pairs.jsonl");
  for (std::string line; std::getline(lines, line);) {
    const Json json = Json::parse(line);
    if (!json["expect"].contains("triangles_intersect")) continue;
    const Shape a = read_shape(json["shapeA"], root / "meshes"), b = read_shape(json["shapeB"], root / "meshes");
    CAPTURE(json["id"]);
    const bool hit =
        !NarrowPhase().intersecting_triangles(a, read_pose(json["poseA"]), b, read_pose(json["poseB"])).empty();
    CHECK(hit == json["expect"]["triangles_intersect"].get<bool>());
    ++records;
  }
  CHECK(records == 28);
}

TEST_CASE("a pair of large meshes in parts: the same bits whoever runs them and when") {
  const Shape ring(torus(1, 0.4, 240, 120)), small(torus(0.9, 0.3, 180, 140));
  std::size_t runs = 0, most = 0, floods = 0;
  const auto backwards = [&](std::size_t parts, const std::function<void(std::size_t)>& part) {
    ++runs;
    most = std::max(most, parts);
    floods += parts == 2 ? 1 : 0;  // one of each mesh
    for (std::size_t i = parts; i-- > 0;) part(i);
  };
  const auto at_once = [](std::size_t parts, const std::function<void(std::size_t)>& part) {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < 4; ++k)
      threads.emplace_back([&, k] {
        for (std::size_t i = k; i < parts; i += 4) part(i);
      });
  };
  const NarrowPhase whole, reversed({.parts = backwards}), shared({.parts = at_once});
  for (const double x : {0.5, 1.2, 1.75, 1.9}) {
    CAPTURE(x);
    Pose a, b;
    b.rotation = Eigen::AngleAxisd(0.4, Vec3(1, 2, 0.5).normalized()).toRotationMatrix();
    b.translation = Vec3(x, 0.03, 0.01);
    std::vector<Contact> expected;
    const PairAnswer answer = whole.solve(ring, a, small, b, Request::contacts, &expected);
    for (const NarrowPhase* other : {&reversed, &shared}) {
      std::vector<Contact> contacts;
      const PairAnswer same = other->solve(ring, a, small, b, Request::contacts, &contacts);
      CHECK(same.signed_distance == answer.signed_distance);
      REQUIRE(contacts.size() == expected.size());
      for (std::size_t i = 0; i < contacts.size(); ++i) {
        CHECK(contacts[i].point == expected[i].point);
        CHECK(contacts[i].depth == expected[i].depth);
        CHECK(contacts[i].feature == expected[i].feature);
      }
    }
    if (x == 1.2) CHECK(!expected.empty());
  }
  CHECK(runs >= 3);
  CHECK(most >= 64);
  CHECK(floods >= 2);
  const auto fails = [](std::size_t, const std::function<void(std::size_t)>&) { throw std::bad_alloc(); };
  std::vector<Contact> contacts;
  Pose beside;
  beside.translation = Vec3(1.2, 0, 0);
  CHECK_THROWS_AS(NarrowPhase({.parts = fails}).solve(ring, Pose{}, small, beside, Request::contacts, &contacts),
                  std::bad_alloc);
}

TEST_CASE("a point is inside a torus by its formula") {
  const MeshModel mesh = build_mesh(torus(1, 0.4, 96, 64));
  std::mt19937_64 random(23);
  int inside = 0;
  for (int i = 0; i < 3000; ++i) {
    // Many in planes that contain edges of the mesh.
    Vec3 p = random_point(random, 1.5);
    if (i % 2) p[i % 3] = 0;
    const double from_core = std::hypot(p.head<2>().norm() - 1, p.z());
    if (std::abs(from_core - 0.4) < 0.002) continue;
    CAPTURE(p.transpose());
    REQUIRE(is_inside(mesh, p) == (from_core < 0.4));
    inside += from_core < 0.4;
  }
  CHECK(inside > 300);
}

TEST_CASE("solid meshes collide when one holds the other; surfaces do not") {
  Mesh shell = torus(2, 0.8, 24, 24), small = box_mesh(Vec3(0.1, 0.1, 0.1));
  const Pose in = Pose::at(2, 0, 0), out;
  for (const bool solid : {true, false}) {
    shell.solid = solid;
    const Shape outer(shell);
    for (const Shape& inner : {Shape(small), Shape(Box{Vec3(0.1, 0.1, 0.1)}), Shape(Sphere{0.05}),
                               Shape(Convex{{Vec3(0, 0, 0), Vec3(0.1, 0, 0)}})}) {
      CAPTURE(name(inner.kind()));
      CHECK(collide(outer, Pose{}, inner, in) == solid);
      CHECK(collide(inner, in, outer, Pose{}) == solid);
      CHECK_FALSE(collide(outer, Pose{}, inner, out));
      const PairAnswer r = NarrowPhase().solve(outer, Pose{}, inner, in, Request::distance);
      CHECK((r.signed_distance < 0) == solid);
      if (solid) {
        // A translation of the inner one out is at least the tube's radius; the bound must contain the true depth.
        CHECK(-r.signed_distance > 0.6);
        CHECK(-r.signed_distance - separation(outer, Pose{}, inner, in, r.normal) > -1e-6);
        CHECK_FALSE(contacts_of(outer, Pose{}, inner, in).empty());
      }
    }
  }
}

TEST_CASE("distance of disjoint meshes is that of all triangles against all") {
  const Mesh ring = torus(1, 0.3, 10, 8), cube = box_mesh(Vec3(1, 1, 1), 2);
  const Shape a(ring), b(cube), box(Box{Vec3(1, 1, 1)});
  std::mt19937_64 random(24);
  for (int i = 0; i < 20; ++i) {
    const Pose pa = random_pose(random, 1);
    Pose pb = random_pose(random, 1);
    pb.translation.x() += 2.6;
    if (collide(a, pa, b, pb)) continue;
    double want = 1e9;
    for (std::uint32_t x = 0; x < ring.triangles.size(); ++x)
      want = std::min(
          want, NarrowPhase().solve(Triangle{mesh_of(a).corners(x)}, pa, box, pb, Request::distance).signed_distance);
    const PairAnswer meshes = NarrowPhase().solve(a, pa, b, pb, Request::distance);
    const PairAnswer convex = NarrowPhase().solve(a, pa, box, pb, Request::distance);
    const PairAnswer swapped = NarrowPhase().solve(b, pb, a, pa, Request::distance);
    CAPTURE(i);
    CHECK(meshes.signed_distance == Approx(want).margin(1e-12));
    CHECK(convex.signed_distance == Approx(want).margin(1e-12));
    CHECK(swapped.signed_distance == meshes.signed_distance);
    CHECK(swapped.point_a == meshes.point_b);
    CHECK(swapped.normal == -meshes.normal);
    CHECK((meshes.point_b - meshes.point_a).norm() == Approx(want).margin(1e-12));
    CHECK((meshes.point_b - meshes.point_a).dot(meshes.normal) == Approx(want).margin(1e-12));
  }
}

TEST_CASE("contacts of meshes that are apart say how far at least, linked and nested ones too") {
  const Shape ring(torus(1, 0.3, 32, 18)), small(torus(0.4, 0.1, 12, 8)), block(box_mesh({0.5, 0.7, 0.3}, 4));
  const Shape far_off([] {
    Mesh mesh = box_mesh({0.4, 0.4, 0.4}, 2);
    for (Vec3& v : mesh.vertices) v += Vec3(300, -200, 100);
    return mesh;
  }());
  std::mt19937_64 random(41);
  int apart = 0, known = 0, known_close = 0, overlapping_hulls = 0;
  for (const Shape* other : {&ring, &small, &block, &far_off})
    for (int i = 0; i < 150; ++i) {
      Pose a{random_turn(random).toRotationMatrix(), random_point(random, i % 5 == 0 ? 1e4 : 1.0)};
      Pose b{random_turn(random).toRotationMatrix(), a.translation + random_point(random, 1.5)};
      if (other == &far_off) b.translation -= b.rotation * Vec3(300, -200, 100);
      if (i % 2 == 0) b.rotation = (b.rotation * 1e6).array().round() / 1e6;
      std::vector<Contact> contacts;
      const PairAnswer answer = NarrowPhase().solve(ring, a, *other, b, Request::contacts, &contacts);
      const PairAnswer back = NarrowPhase().solve(*other, b, ring, a, Request::contacts, &contacts);
      REQUIRE(back.signed_distance == answer.signed_distance);
      const PairAnswer no_gap =
          NarrowPhase({.mesh_gaps = false}).solve(ring, a, *other, b, Request::contacts, &contacts);
      REQUIRE(no_gap.collide == answer.collide);
      if (answer.collide) REQUIRE(no_gap.signed_distance == answer.signed_distance);
      if (!answer.collide && answer.normal.isZero(0)) REQUIRE(no_gap.signed_distance == 0);  // by the triangles
      if (answer.collide) continue;
      const PairAnswer truth = NarrowPhase().solve(ring, a, *other, b, Request::distance);
      ++apart;
      known += answer.signed_distance > 1e-6 ? 1 : 0;
      overlapping_hulls += answer.normal.isZero(0) ? 1 : 0;
      REQUIRE(answer.signed_distance >= 0);
      REQUIRE(answer.signed_distance <= truth.signed_distance * (1 + 1e-12));
      // So near that single precision cannot decide: two triangles do.
      const Pose close = moved(b, -(1 - 1e-6) * truth.signed_distance * truth.normal);
      const PairAnswer nearly = NarrowPhase().solve(ring, a, *other, close, Request::contacts, &contacts);
      if (nearly.collide) continue;
      const double gap = NarrowPhase().solve(ring, a, *other, close, Request::distance).signed_distance;
      REQUIRE(nearly.signed_distance <= gap);
      known_close += nearly.signed_distance > 0.5 * gap ? 1 : 0;
    }
  CHECK(known_close > apart / 2);
  CHECK(overlapping_hulls > 50);
  CHECK(known > apart * 9 / 10);
}

TEST_CASE("signed distance of overlapping meshes: the bounds hold the truth") {
  const Shape cube(box_mesh(Vec3(1, 1, 1), 3)), box(Box{Vec3(1, 1, 1)});
  std::mt19937_64 random(25);
  int overlaps = 0, certain = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose pa = random_pose(random, 0.5);
    const Pose pb = random_pose(random, 0.5);
    // The depth of two boxes is known from the solver of boxes.
    const double want = -NarrowPhase().solve(box, pa, box, pb, Request::distance).signed_distance;
    if (want <= 0) continue;
    ++overlaps;
    for (const Shape& other : {cube, box}) {
      const PairAnswer r = NarrowPhase().solve(cube, pa, other, pb, Request::distance);
      CAPTURE(i);
      CHECK(r.collide);
      CHECK(-r.signed_distance >= want - 1e-9);
      CHECK(-r.signed_distance - r.error_bound <= want + 1e-9);
      CHECK((r.status == Status::ok) == (r.error_bound == 0));
      certain += r.status == Status::ok;
    }
  }
  CHECK(overlaps > 20);
  CHECK(certain > 0);
}

TEST_CASE("contacts of shallow solid meshes separate them, with few points") {
  struct Sample {
    const char* what;
    Shape a, b;
    double depth, least;  // fraction of poses that the deepest contact alone separates
  };
  const Shape ring(torus(0.6, 0.25, 24, 24)), cube(box_mesh(Vec3(1, 1, 1), 3));
  for (const Sample& s : {Sample{"tori, barely", ring, ring, 1e-6, 0.95}, Sample{"tori", ring, ring, 0.01, 0.3},
                          Sample{"boxes, barely", cube, cube, 1e-6, 0.95}, Sample{"boxes", cube, cube, 0.01, 0.7},
                          Sample{"torus and box", ring, cube, 1e-6, 0.95}}) {
    std::mt19937_64 random(26);
    int free = 0;
    for (int i = 0; i < 60; ++i) {
      const Pose pa = Pose::from(random_turn(random), Vec3(0, 0, 0));
      Pose pb = Pose::from(random_turn(random), Vec3(0, 0, 0));
      const Vec3 d = random_point(random, 1).normalized();
      pb.translation = d * (separation(s.a, pa, s.b, pb, d) - s.depth);
      const auto contacts = contacts_of(s.a, pa, s.b, pb);
      CAPTURE(s.what);
      CAPTURE(i);
      REQUIRE_FALSE(contacts.empty());
      CHECK(contacts.size() <= 12);
      const auto& deepest = *std::max_element(contacts.begin(), contacts.end(),
                                              [](const Contact& x, const Contact& y) { return x.depth < y.depth; });
      CHECK(deepest.normal.dot(d) > 0);
      CHECK(deepest.depth <= 1.2 * s.depth + 1e-9);
      free += !collide(s.a, pa, s.b, moved(pb, deepest.normal * (1.01 * deepest.depth + 1e-9)));

      const auto swapped = contacts_of(s.b, pb, s.a, pa);
      REQUIRE(swapped.size() == contacts.size());
      for (std::size_t k = 0; k < contacts.size(); ++k) {
        CHECK(swapped[k].normal == -contacts[k].normal);
        CHECK(swapped[k].point == contacts[k].point);
        CHECK(swapped[k].depth == contacts[k].depth);
        CHECK(swapped[k].feature == contacts[k].feature);
      }
    }
    CAPTURE(free);
    CHECK(free >= s.least * 60);
  }
}

TEST_CASE("a mesh box standing on others has four contacts straight up, of the depth it sank in") {
  const Shape cube(box_mesh(Vec3(1, 1, 1), 3)), slab(box_mesh(Vec3(4, 4, 1), 1));
  const double sunk = 0.01;
  const Pose below, above = Pose::from(Quat(Eigen::AngleAxisd(0.3, Vec3::UnitZ())), Vec3(0.2, -0.1, 1 - sunk));
  for (const Shape& ground : {slab, Shape(Box{Vec3(4, 4, 1)}), Shape(HalfSpace{Vec3::UnitZ(), 0.5})}) {
    CAPTURE(name(ground.kind()));
    const auto contacts = contacts_of(ground, below, cube, above);
    CHECK(contacts.size() == 4);
    double low_x = 9, high_x = -9;
    for (const Contact& c : contacts) {
      CHECK(c.normal.z() == Approx(1));
      CHECK(c.depth == Approx(sunk));
      CHECK(c.point.z() == Approx(0.5 - sunk / 2));
      low_x = std::min(low_x, c.point.x());
      high_x = std::max(high_x, c.point.x());
    }
    CHECK(high_x - low_x > 0.9);
  }
}

// From a random search with exact answers: two surfaces of boxes that stood on each other exactly had contacts as deep
// as the boxes are wide; a triangle in the plane of a mesh had some on both sides.
TEST_CASE("faces that lie on each other have contacts without depth over all that they share") {
  // A step: an L from the side, two high and wide.
  const Mesh step =
      prism({{0, 0}, {2, 0}, {2, 2}, {1, 2}, {1, 1}, {0, 1}}, {{0, 1, 4}, {0, 4, 5}, {1, 2, 3}, {1, 3, 4}}, 2);
  const auto surface = [](Mesh mesh) {
    mesh.solid = false;
    return Shape(mesh);
  };
  const Mesh slab = box_mesh(Vec3(3, 1, 2), 2), cube = box_mesh(Vec3(0.8, 0.8, 0.8)),
             fine = box_mesh(Vec3(0.8, 0.8, 0.8), 3);
  const Mesh cover{{{-0.4, 0, -0.4}, {0.4, 0, -0.4}, {0.4, 0, 0.4}, {-0.4, 0, 0.4}}, {{0, 2, 1}, {0, 3, 2}}};
  const struct {
    Shape below, above;
    double height;  // of the upper body, to stand on the lower one
    double low_x, high_x;
  } rows[] = {
      {surface(slab), surface(cube), 0.9, -1.5, 1.5}, {surface(slab), surface(fine), 0.9, -1.5, 1.5},
      {surface(slab), Shape(cube), 0.9, -1.5, 1.5},   {Shape(step), Shape(cube), 1.4, 0, 1},
      {Shape(step), surface(fine), 1.4, 0, 1},        {surface(step), surface(cube), 1.4, 0, 1},
      {surface(slab), Shape(cover), 0.5, -1.5, 1.5},  {surface(step), Shape(cover), 1, 0, 1},
  };
  for (const auto& row : rows)
    for (const Mat3& turn : {Mat3(Mat3::Identity()), Quat(0.8, 0.1, -0.5, 0.3).normalized().toRotationMatrix()})
      for (const double shift : {0.1, 0.25, 0.4, 0.55, 0.75}) {
        // At most half of the cube hangs over an end, none of it into the step's wall. When rotated, rounding would
        // decide contact.
        const double sunk = turn(0, 0) == 1 ? 0 : 1e-13;
        if (sunk > 0 && &row - rows >= 6) continue;
        const double at = row.low_x + shift;
        const Pose below{turn, Vec3(1, -2, 0.5)},
            above{turn, below * Vec3(std::min(at, row.high_x - 0.4 - 1e-3), row.height - sunk, 0.1)};
        CAPTURE(&row - rows, shift, turn(0, 0));
        for (const bool exchanged : {false, true}) {
          const auto contacts = exchanged ? contacts_of(row.above, above, row.below, below)
                                          : contacts_of(row.below, below, row.above, above);
          if (sunk == 0) CHECK(contacts.size() == 4);
          double low = 9, high = -9;
          for (const Contact& c : contacts) {
            CHECK(c.depth <= 1e-12);
            CHECK((c.normal - (exchanged ? -1.0 : 1.0) * turn.col(1)).norm() < 1e-9);
            const Vec3 p = turn.transpose() * (c.point - above.translation);
            CHECK(std::abs(p.z()) < 0.4 + 1e-9);
            if (sunk == 0) CHECK(std::abs(p.z()) > 0.4 - 1e-9);
            low = std::min(low, p.x()), high = std::max(high, p.x());
          }
          CHECK(low == Approx(std::max(-0.4, row.low_x - std::min(at, row.high_x - 0.4 - 1e-3))).margin(1e-9));
          CHECK(high == Approx(0.4).margin(1e-9));
        }
      }
}

// From the same search: half of the triangles, depending on their orientation, were pushed out at the far side.
TEST_CASE("sheets of many triangles that lie on each other have four contacts at the corners of what they share") {
  const auto sheet = [](std::uint32_t n) {
    Mesh mesh;
    for (std::uint32_t i = 0; i <= n; ++i)
      for (std::uint32_t j = 0; j <= n; ++j) mesh.vertices.emplace_back(10.0 * i / n, 10.0 * j / n, 0);
    for (std::uint32_t i = 0; i < n; ++i)
      for (std::uint32_t j = 0; j < n; ++j) {
        const std::uint32_t at = i * (n + 1) + j;
        mesh.triangles.push_back({at, at + n + 1, at + n + 2});
        mesh.triangles.push_back({at, at + n + 2, at + 1});
      }
    return Shape(mesh);
  };
  const Shape coarse = sheet(7), fine = sheet(25);
  const auto contacts = contacts_of(coarse, Pose{}, fine, Pose::at(3.013, 1.017, 0));
  REQUIRE(contacts.size() == 4);
  for (const double x : {3.013, 10.0})
    for (const double y : {1.017, 10.0})
      CHECK(std::any_of(contacts.begin(), contacts.end(),
                        [&](const Contact& c) { return (c.point - Vec3(x, y, 0)).norm() < 1e-9; }));
  for (const Contact& c : contacts) CHECK((c.depth == 0 && std::abs(c.normal.z()) == 1));
}

TEST_CASE("a triangle in a face of a solid mesh has the contacts of its distance, whichever way round its corners go") {
  const Shape slab(box_mesh(Vec3(3, 3, 0.4), 2));
  const Vec3 p(-0.1, -0.2, 0), q(0.1, -0.2, 0), r(0, 0.2, 0);
  for (const Shape& sheet : {Shape(Triangle{{p, q, r}}), Shape(Triangle{{q, p, r}})})
    for (const Mat3& turn : {Mat3(Mat3::Identity()), Quat(0.8, 0.1, -0.5, 0.3).normalized().toRotationMatrix()})
      for (const bool exchanged : {false, true}) {
        const Pose below{turn, Vec3(1, 2, 3)}, above{turn, below * Vec3(0.3, -0.2, 0.2 - 1e-4)};
        const auto contacts =
            exchanged ? contacts_of(sheet, above, slab, below) : contacts_of(slab, below, sheet, above);
        CAPTURE(turn(0, 0), exchanged);
        CHECK(contacts.size() == 3);
        for (const Contact& c : contacts) {
          CHECK(c.depth == Approx(1e-4).margin(1e-12));
          CHECK((c.normal - (exchanged ? -1.0 : 1.0) * turn.col(2)).norm() < 1e-9);
        }
      }
}

TEST_CASE("surfaces of convex bodies that overlap little are as deep as their hulls") {
  for (const int n : {1, 3})
    for (const Vec3& to : {Vec3(0, 0, 1), Vec3(0.01, 0.01, 0.99), Vec3(0.25, 0.3, 0.98), Vec3(-0.4, 0.97, 0.2)}) {
      Mesh mesh = box_mesh(Vec3(1, 1, 1), n);
      mesh.solid = false;
      const Shape cube(mesh);
      const Pose there = Pose::at(to.x(), to.y(), to.z());
      const PairAnswer x = NarrowPhase().solve(cube, {}, cube, there, Request::distance);
      const PairAnswer boxes =
          NarrowPhase().solve(Box{Vec3(1, 1, 1)}, {}, Box{Vec3(1, 1, 1)}, there, Request::distance);
      CAPTURE(n, to.transpose());
      CHECK(x.status == Status::ok);
      CHECK(x.collide);
      CHECK(x.signed_distance == Approx(boxes.signed_distance).margin(1e-12));
      CHECK((x.normal - boxes.normal).norm() < 1e-9);
    }
}

TEST_CASE("margins give contacts across a gap for half-spaces and convex shapes") {
  const Shape cube(box_mesh(Vec3(1, 1, 1), 2));
  const Pose above = Pose::at(0, 0, 1.05);
  const Triangle triangle{{Vec3(-9, -9, 0.5), Vec3(9, -9, 0.5), Vec3(0, 9, 0.5)}};
  for (const Shape& ground : {Shape(Box{Vec3(4, 4, 1)}), Shape(HalfSpace{Vec3::UnitZ(), 0.5}), Shape(triangle)}) {
    CHECK(contacts_of(ground, Pose{}, cube, above).empty());
    const auto contacts = contacts_of(ground, Pose{}, cube, above, 0.1);
    CHECK(contacts.size() == 4);
    for (const Contact& c : contacts) {
      CHECK(c.depth == Approx(-0.05));
      CHECK((c.normal - Vec3::UnitZ()).norm() < 1e-12);
    }
    for (const Contact& c : contacts_of(cube, above, ground, Pose{}, 0.1)) CHECK(c.normal.z() == Approx(-1));
  }
}

TEST_CASE("identical, touching and zero-area meshes have finite answers") {
  Mesh sick = torus(1, 0.3, 8, 6);
  sick.solid = false;
  sick.triangles.push_back({0, 0, 0});
  sick.triangles.push_back({0, 1, 1});
  sick.triangles.push_back({5, 9, 5});
  const Shape ring(torus(1, 0.3, 8, 6)), cube(box_mesh(Vec3(1, 1, 1))), ill(sick);
  const std::vector<Shape> shapes{ring,
                                  cube,
                                  ill,
                                  Sphere{0},
                                  Sphere{0.5},
                                  Box{Vec3(1, 1, 1)},
                                  Capsule{0.3, 1},
                                  Cylinder{0.5, 1},
                                  Cone{0.5, 1},
                                  Ellipsoid{Vec3(0.5, 0.6, 0.7)},
                                  HalfSpace{Vec3::UnitX(), 0},
                                  Shape(Convex{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}}),
                                  Triangle{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)}},
                                  Triangle{{Vec3(0.5, 0, 0), Vec3(0.5, 0, 0), Vec3(0.5, 0, 0)}}};
  for (const Shape& mesh : {ring, cube, ill})
    for (const Shape& other : shapes)
      for (const Vec3& at : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0), Vec3(1, 1, 1), Vec3(5, 0, 0)}) {
        const Pose pose{Mat3::Identity(), at};
        CAPTURE(name(mesh.kind()));
        CAPTURE(name(other.kind()));
        CAPTURE(at.transpose());
        const PairAnswer d = NarrowPhase().solve(mesh, Pose{}, other, pose, Request::distance);
        CHECK(std::isfinite(d.signed_distance));
        CHECK(std::isfinite(d.error_bound));
        CHECK(d.point_a.allFinite());
        CHECK(d.point_b.allFinite());
        CHECK(d.normal.norm() == Approx(1));
        const bool hit = collide(mesh, Pose{}, other, pose);
        CHECK(hit == collide(other, pose, mesh, Pose{}));
        if (std::abs(d.signed_distance) > 1e-9) CHECK(hit == (d.signed_distance < 0));
        const auto contacts = contacts_of(mesh, Pose{}, other, pose);
        CHECK((hit || contacts.empty()));
        // For boxes that share a face, all the same.
        if (hit && other.kind() == ShapeKind::mesh && &other == &shapes[1] && mesh_of(mesh).triangles.size() == 12 &&
            at == Vec3(1, 0, 0))
          for (const Contact& c : contacts) {
            CHECK(c.depth == Approx(0).margin(1e-9));
            CHECK(c.normal.x() == Approx(1));
          }
      }
}

TEST_CASE("the normal between surfaces a hair apart is their faces'") {
  const NarrowPhase solver;
  const Shape floor(Mesh{{{-9, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-9, 9, 0}}, {{0, 1, 2}, {0, 2, 3}}}),
      plate(Triangle{{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}}});
  std::mt19937_64 random(5);
  int apart = 0;
  for (int k = 0; k < 200; ++k) {
    const Mat3 turn = random_turn(random).toRotationMatrix();
    const Pose below{turn, Vec3::Zero()};
    const Pose above{turn, turn * Vec3(random_point(random, 3).x(), 0.25, std::pow(10.0, -13 + k % 7))};
    const PairAnswer answer = solver.solve(floor, below, plate, above, Request::distance);
    CAPTURE(k, answer.signed_distance);
    if (!(answer.signed_distance > 0)) continue;
    ++apart;
    CHECK((answer.normal - turn.col(2)).norm() < 1e-9);
  }
  CHECK(apart > 150);
}
