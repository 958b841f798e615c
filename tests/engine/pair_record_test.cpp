// Pair records of `tandem query`.
#include "formats/pair_record.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "catch.h"

using namespace tandem;

namespace {

Json ask_line(std::string_view line, const QueryOptions& options = {}) {
  ShapeReader shapes;
  const AnsweredLine answered = answer_line(line, 7, shapes, options);
  const Json json = parse_json(answered.text);
  CHECK(answered.ok == (json.at("status") != "error"));
  return json;
}

std::vector<std::string> keys(const Json& object) {
  std::vector<std::string> out;
  for (const auto& [key, value] : object.items()) out.push_back(key);
  return out;
}

// Two unit spheres, the second at x.
std::string spheres(double x, const std::string& rest) {
  return R"({"id":"s","note":"passed over","shapeA":{"kind":"sphere","radius":1},"poseA":{"t":[0,0,0]},)"
         R"("shapeB":{"kind":"sphere","radius":1},"poseB":{"t":[)" +
         std::to_string(x) + R"(,0,0]},)" + rest + "}";
}

using Keys = std::vector<std::string>;

}  // namespace

TEST_CASE("pair record: the answer has what was asked and nothing else") {
  CHECK(keys(ask_line(spheres(3, R"("ask":["collide"])"))) == Keys{"id", "status", "collide"});
  CHECK(keys(ask_line(spheres(3, R"("ask":["distance"])"))) == Keys{"id", "status", "signed_distance", "points"});
  CHECK(keys(ask_line(spheres(1, R"("ask":["normal"])"))) == Keys{"id", "status", "normal"});
  CHECK(keys(ask_line(spheres(1, R"("ask":["contacts"])"))) == Keys{"id", "status", "contacts"});
  CHECK(keys(ask_line(spheres(1, R"("ask":["toi"],"tmax":1)"))) == Keys{"id", "status", "toi"});
  CHECK(keys(ask_line(spheres(1, R"("ask":["depth_bounds"])"))) == Keys{"id", "status", "depth_bounds"});
  CHECK(keys(ask_line(spheres(1, R"("ask":["collide"])"), {.narrow_phase = {}, .time = true})) ==
        Keys{"id", "status", "collide", "ns"});
}

TEST_CASE("pair record: two spheres") {
  const Json apart = ask_line(spheres(3, R"("ask":["collide","distance","normal"])"));
  CHECK(apart["collide"] == false);
  CHECK(apart["signed_distance"] == 1.0);
  CHECK(apart["points"] == parse_json("[[1,0,0],[2,0,0]]"));
  CHECK(apart["normal"] == parse_json("[1,0,0]"));
  CHECK(ask_line(spheres(2, R"("ask":["collide"])"))["collide"] == true);  // touching counts
  const Json deep = ask_line(spheres(1, R"("ask":["penetration","contacts"])"));
  CHECK(deep["signed_distance"] == -1.0);
  const Json bounds = ask_line(spheres(1, R"("ask":["depth_bounds"],"most_boxes":10)"))["depth_bounds"];
  CHECK(bounds["lower"] == 1.0);
  CHECK(bounds["upper"].get<double>() == Approx(1).margin(1e-10));
  CHECK(bounds["translation"][0].get<double>() == Approx(1).margin(1e-10));
  REQUIRE(deep["contacts"].size() == 1);
  CHECK(deep["contacts"][0]["depth"] == 1.0);
  CHECK(keys(deep["contacts"][0]) == Keys{"point", "normal", "depth"});
}

TEST_CASE("pair record: rotations of few digits put corners where they say, R v + t") {
  const std::string boxes = R"("shapeA":{"kind":"box","size":[2,1,0.5]},"shapeB":{"kind":"box","size":[1,1.5,1]})";
  const std::string loose_a = R"("R":[[0.9210610,-0.3894183,0],[0.3894183,0.9210610,0],[0,0,1]])";
  const std::string loose_b = R"("R":[[1,0,0],[0,0.8775826,-0.4794255],[0,0.4794255,0.8775826]])";
  const auto corners = [](const Vec3& size, const Mat3& r) {
    std::string text;
    for (unsigned i = 0; i < 8; ++i) {
      const Vec3 v = r * (0.5 * size.cwiseProduct(Vec3(i & 1u ? 1 : -1, i & 2u ? 1 : -1, i & 4u ? 1 : -1)));
      char point[100];
      std::snprintf(point, sizeof point, "%s[%.17g,%.17g,%.17g]", i > 0 ? "," : "", v[0], v[1], v[2]);
      text += point;
    }
    return R"({"kind":"convex","vertices":[)" + text + "]}";
  };
  const Mat3 ra = (Mat3() << 0.9210610, -0.3894183, 0, 0.3894183, 0.9210610, 0, 0, 0, 1).finished();
  const Mat3 rb = (Mat3() << 1, 0, 0, 0, 0.8775826, -0.4794255, 0, 0.4794255, 0.8775826).finished();
  const auto distance = [](const Json& json) { return json["signed_distance"].get<double>(); };
  for (const char* at : {"[0.5,0.7,0.6]", "[2,3,1]", "[0,0,0.97]"}) {
    const std::string rest = std::string(R"("ask":["distance"]})");
    const Json loose = ask_line("{" + boxes + R"(,"poseA":{"t":[0,0,0],)" + loose_a + R"(},"poseB":{"t":)" + at + "," +
                                loose_b + "}," + rest);
    const Json placed =
        ask_line(R"({"shapeA":)" + corners({2, 1, 0.5}, ra) + R"(,"shapeB":)" + corners({1, 1.5, 1}, rb) +
                 R"(,"poseA":{"t":[0,0,0]},"poseB":{"t":)" + at + "}," + rest);
    CAPTURE(at);
    CHECK(std::abs(distance(loose) - distance(placed)) < 1e-14);
  }
  // A half-space and a point: n . R^-1 x = offset.
  const Json plane =
      ask_line(R"({"shapeA":{"kind":"halfspace","normal":[0,1,0],"offset":2},"poseA":{"t":[0,0,0],)" + loose_b +
               R"(},"shapeB":{"kind":"sphere","radius":0},"poseB":{"t":[1,3,5]},)" + R"("ask":["distance"]})");
  const Vec3 n = rb.transpose().inverse() * Vec3(0, 1, 0);
  CHECK(std::abs(distance(plane) - (n.dot(Vec3(1, 3, 5)) - 2) / n.norm()) < 1e-14);
}

TEST_CASE("pair record: a way ends where rotations of six decimals put round shapes' points") {
  // A rotation whose columns are all too short or too long by the same factor makes another shape of the same kind.
  const double scale = GENERATE(1 - 9e-7, 1 + 9e-7);
  const Mat3 turn = Quat(0.5, 0.1, -0.7, 0.3).normalized().toRotationMatrix();
  const Pose loose{scale * turn, Vec3(0.3, 0.2, 5)}, right{turn, loose.translation};
  const auto shapes = [](double by) {
    return std::array<Shape, 2>{Cylinder{by * 0.6, by * 1.5}, Cone{by * 0.6, by * 1.5}};
  };
  Mesh mesh;
  mesh.vertices = {{-2, -2, 0}, {2, -2, 0}, {2, 2, 0.3}, {-2, 2, 0}, {0, 0, 1.2}};
  mesh.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const Shape others[] = {Box{{1, 1, 1}},          Sphere{0.4}, Cylinder{0.3, 2}, Ellipsoid{{1, 0.5, 0.3}},
                          HalfSpace{{0, 0, 1}, 0}, Shape(mesh)};
  const NarrowPhase solver;
  const Pose at{Quat(0.9, 0.2, 0.3, -0.1).normalized().toRotationMatrix(), Vec3(0.1, -0.2, 0.1)};
  int met = 0;
  for (std::size_t i = 0; i < 2; ++i)
    for (const Shape& other : others) {
      const Shape given = shapes(1)[i], scaled = shapes(scale)[i];
      CAPTURE(name(given.kind()), name(other.kind()));
      const PlacedShape a = place(given, loose), b = place(other, at);
      for (const Vec3& v : {Vec3(0, 0, -3), Vec3(-0.1, 0.2, -2)}) {
        const auto found = time_of_impact(solver, a, v, b, Vec3(0.1, 0, 0), 10);
        const auto back = time_of_impact(solver, b, Vec3(0.1, 0, 0), a, v, 10);
        const auto expected = solver.time_of_impact(scaled, right, v, other, at, Vec3(0.1, 0, 0), 10);
        REQUIRE(found.has_value() == expected.has_value());
        if (!expected) continue;
        ++met;
        REQUIRE(back);
        CHECK(std::abs(*found - *expected) < 1e-10);
        CHECK(std::abs(*back - *expected) < 1e-10);
        CHECK_FALSE(time_of_impact(solver, a, v, b, Vec3(0.1, 0, 0), *expected - 1e-7));
        CHECK(time_of_impact(solver, a, v, b, Vec3(0.1, 0, 0), *expected + 1e-7));
        CHECK_FALSE(time_of_impact(solver, a, -v, b, Vec3::Zero(), 10));
      }
      PlacedShape inside = a;
      inside.pose.translation = at.translation + Vec3(0, 0, 0.3);
      CHECK(time_of_impact(solver, inside, Vec3(1, 0, 0), b, Vec3::Zero(), 1) == 0.0);
    }
  CHECK(met >= 20);
  // With the rounded rotations of the record: apart before, touching at the end.
  const Pose rounded{
      (Mat3() << 0.936293, -0.275096, 0.218351, 0.289629, 0.956425, -0.036957, -0.198669, 0.097843, 0.975170)
          .finished(),
      Vec3(0, 0.1, 4)};
  for (const Shape& given : shapes(1))
    for (const Shape& other : others) {
      if (!other.is_convex()) continue;
      CAPTURE(name(given.kind()), name(other.kind()));
      PlacedShape a = place(given, rounded);
      const PlacedShape b = place(other, Pose{rounded.rotation, Vec3::Zero()});
      const Vec3 v(0.1, 0, -2);
      const auto found = time_of_impact(solver, a, v, b, Vec3::Zero(), 10);
      REQUIRE(found);
      a.pose.translation += *found * v;
      const double end = solve(solver, a, b, Request::distance).signed_distance;
      CHECK(end < 1e-12);
      CHECK(end > -1e-14);
    }
}

TEST_CASE("pair record: a cylinder whose rotation is off meets voxels when it meets the first of their cells") {
  const NarrowPhase solver;
  Mat3 off;
  off << 0.936293, -0.275096, 0.218351, 0.289629, 0.956425, -0.036957, -0.198669, 0.097843, 0.975170;
  const Shape grid(Voxels{{{{0, 0, 0}, 1}, {{2, 1, 3}, 0}, {{-2, 0, -1}, 0}, {{-1, 4, 0}, 0}}, 0.25, Vec3(0.1, 0, 0)});
  const PlacedShape cylinder = place(Cylinder{0.1, 0.5}, Pose{off, Vec3(0.2, 0.3, 4)});
  REQUIRE(cylinder.rest);
  int met = 0;
  for (const double rounding : {0.0, 0.05})
    for (const double x : {-0.15, -0.1, -0.05, 0.0, 0.05, 0.1}) {
      CAPTURE(rounding, x);
      const Vec3 v(x, x / 2, -2);
      const PlacedShape voxels = place(grid.rounded(rounding), Pose{});
      std::optional<double> first;
      for (const VoxelCell& cell : grid.cells()) {
        const double edge = 0.25 * (1 << cell.level);
        const Vec3 corner = Vec3(0.1, 0, 0) + 0.25 * Vec3(cell.corner[0], cell.corner[1], cell.corner[2]);
        const PlacedShape box = place(Shape(Box{Vec3::Constant(edge)}).rounded(rounding),
                                      Pose{Mat3::Identity(), corner + Vec3::Constant(edge / 2)});
        const auto time = time_of_impact(solver, cylinder, v, box, Vec3::Zero(), 10);
        if (time && !(first && *first <= *time)) first = time;
      }
      const auto found = time_of_impact(solver, cylinder, v, voxels, Vec3::Zero(), 10);
      const auto back = time_of_impact(solver, voxels, Vec3::Zero(), cylinder, v, 10);
      REQUIRE(found.has_value() == first.has_value());
      REQUIRE(back.has_value() == first.has_value());
      if (!first) continue;
      ++met;
      CHECK(std::abs(*found - *first) < 1e-9);
      CHECK(std::abs(*back - *first) < 1e-9);
      CHECK_FALSE(time_of_impact(solver, cylinder, v, voxels, Vec3::Zero(), *first - 1e-6));
    }
  CHECK(met > 6);
}

TEST_CASE("pair record: round shapes stand where rotations of six decimals put their points, R v + t") {
  const Mat3 r = (Mat3() << 0.936293, -0.275096, 0.218351, 0.289629, 0.956425, -0.036957, -0.198669, 0.097843, 0.975170)
                     .finished();
  const std::string pose = R"({"R":[[0.936293,-0.275096,0.218351],[0.289629,0.956425,-0.036957],)"
                           R"([-0.198669,0.097843,0.975170]],"t":[0.1,0.2,0.3]})";
  const Vec3 t(0.1, 0.2, 0.3);
  // The support of a core along m in its frame, and the radius about it.
  const struct {
    const char* shape;
    double (*reach)(const Vec3&);
    double radius;
  } rows[] = {
      {R"({"kind":"sphere","radius":0.7})", [](const Vec3&) { return 0.0; }, 0.7},
      {R"({"kind":"capsule","radius":0.2,"length":1.5})", [](const Vec3& m) { return 0.75 * std::abs(m[2]); }, 0.2},
      {R"({"kind":"cylinder","radius":0.6,"length":1.5})",
       [](const Vec3& m) { return 0.6 * std::hypot(m[0], m[1]) + 0.75 * std::abs(m[2]); }, 0},
      {R"({"kind":"cone","radius":0.6,"length":1.5})",
       [](const Vec3& m) { return std::max(0.6 * std::hypot(m[0], m[1]) - 0.75 * m[2], 0.75 * m[2]); }, 0},
      {R"({"kind":"ellipsoid","radii":[0.9,0.5,0.3]})",
       [](const Vec3& m) { return Vec3(0.9 * m[0], 0.5 * m[1], 0.3 * m[2]).norm(); }, 0}};
  const Vec3 n(2.0 / 7, 3.0 / 7, 6.0 / 7);
  const std::string rest = R"("poseB":{"t":[0,0,0]},"ask":["distance","normal","contacts","collide"]})";
  for (const auto& row : rows)
    for (const double offset : {-0.9, -0.2, 1.2}) {
      char plane[200];
      std::snprintf(plane, sizeof plane, R"("shapeB":{"kind":"halfspace","normal":[2,3,6],"offset":%.17g},)",
                    7 * offset);
      const Json found =
          ask_line(std::string(R"({"shapeA":)") + row.shape + R"(,"poseA":)" + pose + "," + plane + rest);
      const double expected = n.dot(t) - row.reach(-(r.transpose() * n)) - row.radius - offset;
      CAPTURE(row.shape, offset);
      CHECK(std::abs(found["signed_distance"].get<double>() - expected) < 1e-14);
      CHECK(found["collide"] == (expected <= 0));
      CHECK(found["contacts"].empty() == (expected > 0));
    }
  // Two of them, compared with the separation along the normal found, which is the maximum.
  const char* at[] = {"[0.5,0.7,0.6]", "[1,1,1.5]", "[1.2,1.4,-0.5]"};
  for (const auto& a : rows)
    for (const auto& b : rows)
      for (const char* place : at) {
        const std::string other =
            std::string(R"({"R":[[1,0,0],[0,0.877583,-0.479426],[0,0.479426,0.877583]],"t":)") + place + "}";
        const Mat3 rb = (Mat3() << 1, 0, 0, 0, 0.877583, -0.479426, 0, 0.479426, 0.877583).finished();
        const Json found = ask_line(std::string(R"({"shapeA":)") + a.shape + R"(,"poseA":)" + pose + R"(,"shapeB":)" +
                                    b.shape + R"(,"poseB":)" + other + R"(,"ask":["distance","normal"]})");
        const Json to = parse_json(place), normal = found["normal"];
        const Vec3 tb(to[0].get<double>(), to[1].get<double>(), to[2].get<double>());
        const auto separation = [&](Vec3 m) {
          m.normalize();
          return m.dot(tb - t) - a.reach(r.transpose() * m) - b.reach(-(rb.transpose() * m)) - a.radius - b.radius;
        };
        const Vec3 m(normal[0].get<double>(), normal[1].get<double>(), normal[2].get<double>());
        const double distance = found["signed_distance"];
        CAPTURE(a.shape, b.shape, place, distance);
        CHECK(std::abs(m.norm() - 1) < 1e-15);
        CHECK(std::abs(distance - separation(m)) < 1e-11);
        for (int k = 0; k < 200; ++k) {
          const Vec3 off(std::sin(3.0 * k), std::sin(5.0 * k + 1), std::sin(7.0 * k + 2));
          CHECK(separation(m + std::pow(10.0, -0.04 * k) * off) <= distance + 1e-11);
        }
      }
}

TEST_CASE("pair record: a rotation of six decimals decides which translation out of a cylinder is the least") {
  const Mat3 r = (Mat3() << 0.936293, -0.275096, 0.218351, 0.289629, 0.956425, -0.036957, -0.198669, 0.097843, 0.975170)
                     .finished();
  const Json found = ask_line(
      R"({"shapeA":{"kind":"cylinder","radius":0.6,"length":9},"poseA":{"R":[[0.936293,-0.275096,0.218351],)"
      R"([0.289629,0.956425,-0.036957],[-0.198669,0.097843,0.975170]],"t":[3,0,0]},)"
      R"("shapeB":{"kind":"sphere","radius":0.3},"poseB":{"t":[3,0,0]},"ask":["distance","normal","contacts"]})");
  // Projected along its axis the side is an ellipse, of half axes 0.6 (1 +- 1e-6).
  const Vec3 axis = r.col(2).normalized(), u = axis.cross(Vec3::UnitX()).normalized(), v = axis.cross(u);
  const Vec3 ru = r.transpose() * u, rv = r.transpose() * v;
  const double uu = ru.head<2>().squaredNorm(), uv = ru.head<2>().dot(rv.head<2>()), vv = rv.head<2>().squaredNorm();
  const double angle = 0.5 * std::atan2(2 * uv, uu - vv);  // of the longer one
  const double least = std::sqrt(0.5 * (uu + vv) - std::hypot(0.5 * (uu - vv), uv));
  CHECK(std::abs(found["signed_distance"].get<double>() + 0.3 + 0.6 * least) < 1e-14);
  const Vec3 expected = -std::sin(angle) * u + std::cos(angle) * v;
  const Json n = found["normal"];
  const Vec3 normal(n[0].get<double>(), n[1].get<double>(), n[2].get<double>());
  CHECK(std::min((normal - expected).norm(), (normal + expected).norm()) < 1e-8);
  CHECK_FALSE(found["contacts"].empty());
}

TEST_CASE("pair record: a hair from an apex that a rotation's last decimals move, the normal is the way there") {
  const Json found = ask_line(
      R"({"shapeA":{"kind":"cone","radius":0.6,"length":2},"poseA":{"R":[[1,0,1e-11],[0,1,0],[0,0,1]],"t":[0,0,0]},)"
      R"("shapeB":{"kind":"sphere","radius":0},"poseB":{"t":[0.00000028001,0,1.00000096]},"ask":["distance","normal"]})");
  const Json n = found["normal"];
  CHECK(std::abs(found["signed_distance"].get<double>() - 1e-6) < 1e-15);
  CHECK(std::abs(n[0].get<double>() - 0.28) < 1e-8);
  CHECK(std::abs(n[2].get<double>() - 0.96) < 1e-8);
}

TEST_CASE("pair record: a margin reports gaps as contacts") {
  CHECK(ask_line(spheres(2.5, R"("ask":["contacts"])"))["contacts"].empty());
  const Json near = ask_line(spheres(2.5, R"("ask":["contacts","collide"],"margin":0.6)"));
  CHECK(near["contacts"].size() == 1);
  CHECK(near["contacts"][0]["depth"].get<double>() == Approx(-0.5));
  CHECK(near["collide"] == false);
}

TEST_CASE("pair record: time of impact, null when they never touch") {
  const Json hit = ask_line(spheres(4, R"("ask":["toi"],"velA":[1,0,0],"velB":[-1,0,0],"tmax":2)"));
  CHECK(hit["toi"].get<double>() == Approx(1).margin(1e-10));
  CHECK(ask_line(spheres(4, R"("ask":["toi"],"velA":[1,0,0],"tmax":1)"))["toi"].is_null());
  CHECK(ask_line(spheres(4, R"("ask":["toi"])"))["error"] ==
        "/tmax: missing, allowed: a number >= 0, as toi is asked for");
}

TEST_CASE("pair record: meshes fall until a corner touches where a rotation of six decimals puts it") {
  const Mat3 r = (Mat3() << 0.936293, -0.275096, 0.218351, 0.289629, 0.956425, -0.036957, -0.198669, 0.097843, 0.975170)
                     .finished();
  const std::string body =
      R"({"kind":"mesh","vertices":[[-1,-1,-1],[2,-1,-1],[0,2,-1],[0,0,1]],"triangles":[[0,2,1],[0,1,3],[1,2,3],[2,0,3]])";
  const std::string floor =
      R"({"kind":"mesh","vertices":[[-9,-9,0],[9,-9,0],[9,9,0],[-9,9,0]],"triangles":[[0,1,2],[0,2,3]]},)";
  const std::string turned = R"({"R":[[0.936293,-0.275096,0.218351],[0.289629,0.956425,-0.036957],)"
                             R"([-0.198669,0.097843,0.975170]],"t":[0,0,5]},)";
  double lowest = 9;
  for (const Vec3& v : {Vec3(-1, -1, -1), Vec3(2, -1, -1), Vec3(0, 2, -1), Vec3(0, 0, 1)})
    lowest = std::min(lowest, 5 + r.row(2).dot(v));
  const std::string ask = R"("tmax":20,"ask":["toi","distance","collide","triangles_intersect"]})";
  for (const char* kind : {"}", R"(,"solid":true})"}) {
    const Json first = ask_line(R"({"shapeA":)" + body + kind + R"(,"poseA":)" + turned + R"("shapeB":)" + floor +
                                R"("poseB":{"t":[0,0,0]},"velA":[0,0,-2],)" + ask);
    const Json second = ask_line(R"({"shapeA":)" + floor + R"("poseA":{"t":[0,0,0]},"shapeB":)" + body + kind +
                                 R"(,"poseB":)" + turned + R"("velB":[0,0,-2],)" + ask);
    for (const Json& found : {first, second}) {
      CHECK(std::abs(found["toi"].get<double>() - 0.5 * lowest) < 1e-13);
      CHECK(std::abs(found["signed_distance"].get<double>() - lowest) < 1e-13);
      CHECK(found["collide"] == false);
      CHECK(found["triangles"] == Json::array());
    }
  }
}

TEST_CASE("pair record: triangles that intersect are named by number") {
  const std::string a = R"("shapeA":{"kind":"triangle","vertices":[[0,0,0],[2,0,0],[0,2,0]]},"poseA":{"t":[0,0,0]},)";
  const std::string b = R"("shapeB":{"kind":"triangle","vertices":[[0,0,-1],[0,0,1],[1,1,0]]},)";
  const std::string ask = R"("ask":["triangles_intersect"]})";
  CHECK(ask_line("{" + a + b + R"("poseB":{"t":[0,0,0]},)" + ask)["triangles"] == parse_json("[[0,0]]"));
  CHECK(ask_line("{" + a + b + R"("poseB":{"t":[9,0,0]},)" + ask)["triangles"] == Json::array());
  CHECK(ask_line(spheres(1, R"("ask":["triangles_intersect"])"))["error"] ==
        R"(/ask/0: "triangles_intersect", allowed: for triangles and meshes only)");
}

TEST_CASE("pair record: two triangles a rounding apart collide exactly where they are said to intersect") {
  // A segment and itself, 1e-16 beside an end: they miss each other.
  const std::string segment = R"({"kind":"triangle","vertices":[[1,0,2],[2,2,0],[2,2,0]]})";
  const std::string ask = R"("ask":["collide","triangles_intersect"]})";
  const auto asked = [&](const std::string& x) {
    return ask_line(R"({"shapeA":)" + segment + R"(,"poseA":{"R":[[1,0,0],[0,0,-1],[0,1,0]],"t":[)" + x +
                    R"(,0,1]},"shapeB":)" + segment + R"(,"poseB":{"R":[[1,0,0],[0,-1,0],[0,0,-1]],"t":[1,0,5]},)" +
                    ask);
  };
  CHECK(asked("-1e-16")["triangles"] == Json::array());
  CHECK(asked("-1e-16")["collide"] == false);
  CHECK(asked("0")["triangles"] == parse_json("[[0,0]]"));
  CHECK(asked("0")["collide"] == true);
}

TEST_CASE("pair record: a bad one is answered with its id, line and error") {
  const Json bad = ask_line(spheres(1, R"("ask":["colide"])"));
  CHECK(keys(bad) == Keys{"id", "line", "status", "error"});
  CHECK(bad["id"] == "s");
  CHECK(bad["line"] == 7);
  CHECK(bad["error"] ==
        R"(/ask/0: "colide", allowed: collide, distance, penetration, normal, contacts, triangles_intersect, toi, depth_bounds)");
  const Json garbage = ask_line("{\"id\":5,");
  CHECK(garbage["id"] == 5);
  CHECK(ask_line("}")["id"].is_null());
  CHECK_THAT(garbage["error"].get<std::string>(), Catch::Contains("syntax error"));
  CHECK(ask_line("[1]")["error"] == "document: [1], allowed: an object");
  CHECK(ask_line(spheres(1, R"("ask":[])"))["status"] == "error");
  CHECK(ask_line(spheres(1, R"("ask":"collide")"))["status"] == "error");
  CHECK(ask_line(spheres(1, R"("ask":["collide"],"margin":-1)"))["error"] == "/margin: -1, allowed: a number >= 0");
  CHECK(ask_line(R"({"id":{"x":1},"shapeA":{"kind":"box","size":[1,-1,1]}})")["error"] ==
        "/shapeA/size/1: -1, allowed: a number > 0");
  CHECK(ask_line(R"({"shapeA":{"kind":"sphere","radius":1}})")["error"] == "/shapeB: missing, allowed: a value");
  const std::string half = R"({"kind":"halfspace","normal":[0,0,1],"offset":0})";
  CHECK(ask_line(R"({"shapeA":)" + half + R"(,"shapeB":)" + half +
                 R"(,"poseA":{"t":[0,0,0]},"poseB":{"t":[0,0,0]},"ask":["distance"]})")["status"] == "error");
}

TEST_CASE("pair record: the shared cases, all answered, verdicts and distances as expected") {
  const char* shared = std::getenv("TANDEM_SHARED");
  if (shared == nullptr) TANDEM_SKIP("TANDEM_SHARED, a folder with cases/ and meshes/, is not set");
  std::ifstream in(std::string(shared) + "/cases/pairs.jsonl");
  REQUIRE(in);
  std::size_t records = 0;
  for (std::string line; std::getline(in, line); ++records) {
    const Json asked = parse_json(line), found = ask_line(line);
    CAPTURE(asked["id"]);
    REQUIRE(found["status"] != "error");
    CHECK(found["id"] == asked["id"]);
    const Json& expect = asked["expect"];
    if (found.contains("collide") && expect.contains("collide") && expect["collide"].is_boolean())
      CHECK(found["collide"] == expect["collide"]);
    if (found.contains("signed_distance") && expect.contains("signed_distance")) {
      const double right = expect["signed_distance"];
      CHECK(std::abs(found["signed_distance"].get<double>() - right) <= 1e-5 * std::max(1.0, std::abs(right)));
    }
  }
  CHECK(records > 0);
}
