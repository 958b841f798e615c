// Shapes and poses as JSON.
#include "formats/shape_json.h"

#include <bit>
#include <nlohmann/json.hpp>
#include <random>

#include "catch.h"
#include "message_of.h"
#include "temporary_folder.h"

using namespace tandem;

namespace {

std::string refusal_of_shape(std::string_view text) {
  return message_of([&] {
    const Json json = parse_json(text);
    ShapeReader().read(JsonRef(json));
  });
}

std::string refusal_of_pose(std::string_view text) {
  return message_of([&] {
    const Json json = parse_json(text);
    read_pose(JsonRef(json));
  });
}

Shape shape_of(std::string_view text) {
  const Json json = parse_json(text);
  return ShapeReader().read(JsonRef(json));
}

std::string written(const Shape& shape) {
  JsonWriter out;
  write_shape(out, shape);
  return out.text();
}

constexpr const char* tetrahedron =
    R"({"kind":"mesh","vertices":[[0,0,0],[1,0,0],[0,1,0],[0,0,1]],"triangles":[[0,2,1],[0,1,3],[0,3,2],[1,2,3]]})";

}  // namespace

TEST_CASE("shape JSON: every kind reads as its parameters say") {
  CHECK(shape_of(R"({"kind":"sphere","radius":0})").radius() == 0);
  CHECK(shape_of(R"({"kind":"box","size":[1,2,3]})").half_size() == Vec3(0.5, 1, 1.5));
  CHECK(shape_of(R"({"kind":"capsule","radius":1,"length":0})").length() == 0);
  CHECK(shape_of(R"({"kind":"cylinder","radius":1,"length":2})").kind() == ShapeKind::cylinder);
  CHECK(shape_of(R"({"kind":"cone","radius":1,"length":2})").kind() == ShapeKind::cone);
  CHECK(shape_of(R"({"kind":"ellipsoid","radii":[1,2,3]})").radii() == Vec3(1, 2, 3));
  CHECK(shape_of(R"({"kind":"halfspace","normal":[0,0,2],"offset":4})").offset() == 2);
  CHECK(shape_of(R"({"kind":"plane","normal":[0,0,2],"offset":4})").offset() == 2);
  CHECK(shape_of(R"({"kind":"convex","vertices":[[0,0,0]]})").kind() == ShapeKind::convex);
  CHECK(shape_of(R"({"kind":"triangle","vertices":[[0,0,0],[1,0,0],[2,0,0]]})").kind() == ShapeKind::triangle);
  CHECK(shape_of(tetrahedron).kind() == ShapeKind::mesh);
  const Shape grid = shape_of(R"({"kind":"voxels","cell_size":0.5,"cells":[[4,0,-2],[0,2,4,1]],"origin":[1,0,0]})");
  REQUIRE(grid.cells().size() == 2);
  CHECK(grid.bounds(Pose{}).lo == Vec3(1, 0, -1));
  CHECK(shape_of(R"({"kind":"voxels","cell_size":2,"cells":[[0,0,0]]})").origin() == Vec3::Zero());
  CHECK_THAT(refusal_of_shape(R"({"kind":"voxels","cell_size":1,"cells":[]})"), Catch::Contains("cells is empty"));
  CHECK_THAT(refusal_of_shape(R"({"kind":"voxels","cell_size":1,"cells":[[0,0.5,0]]})"), Catch::Contains("/cells/0/1"));
  CHECK_THAT(refusal_of_shape(R"({"kind":"voxels","cell_size":1,"cells":[[0,0]]})"), Catch::Contains("/cells/0"));
  CHECK_THAT(refusal_of_shape(R"({"kind":"voxels","cell_size":1,"cells":[[0,0,0,21]]})"), Catch::Contains("/cells/0/3"));
  CHECK_THAT(refusal_of_shape(R"({"kind":"voxels","cell_size":1,"cells":[[1048576,0,0]]})"), Catch::Contains("cells[0]"));
  CHECK_THAT(refusal_of_shape(R"({"kind":"voxels","cell_size":1,"cells":[[1e7,0,0]]})"),
             Catch::EndsWith("a whole number from -2^20 to 2^20 - 1"));
  CHECK_THAT(refusal_of_shape(R"({"kind":"voxels","cell_size":0,"cells":[[0,0,0]]})"), Catch::Contains("/cell_size"));
}

TEST_CASE("shape JSON: every kind may have rounding") {
  CHECK(shape_of(R"({"kind":"box","rounding":0.25,"size":[1,2,3]})").rounding() == 0.25);
  CHECK(shape_of(R"({"kind":"cylinder","rounding":0.5,"radius":1,"length":2})").radius() == 1);
  CHECK(shape_of(R"({"kind":"box","size":[1,2,3]})").rounding() == 0);
  CHECK_THAT(refusal_of_shape(R"({"kind":"cone","radius":1,"length":2,"rounding":-1})"), Catch::Contains("/rounding"));
  CHECK_THAT(refusal_of_shape(R"({"kind":"cone","radius":1,"length":2,"rounding":1e40})"), Catch::Contains("rounding"));
  CHECK_THAT(refusal_of_shape(R"({"kind":"sphere","radius":1e30,"rounding":1e30})"),
             Catch::StartsWith("document: sphere: radius is 2e30; it must be "));
}

TEST_CASE("shape JSON: what is written reads back as the same text") {
  const std::string texts[] = {
      R"({"kind":"sphere","radius":0.1})",
      R"({"kind":"box","size":[0.1,1e-30,3]})",
      R"({"kind":"voxels","cell_size":0.1,"origin":[0.1,0,-3],"cells":[[-3,2,5],[0,8,4,2]]})",
      R"({"kind":"capsule","radius":0.3,"length":0.7})",
      R"({"kind":"cylinder","radius":0.3,"length":0.7})",
      R"({"kind":"cone","radius":0.3,"length":0.7})",
      R"({"kind":"ellipsoid","radii":[0.1,0.2,0.3]})",
      R"({"kind":"convex","vertices":[[0,0,0],[0.1,0,0],[0,0.1,0],[0,0,0.3]]})",
      R"({"kind":"triangle","vertices":[[0,0,0],[0.1,0,0],[0.2,0,0]]})",
      tetrahedron,
      R"({"kind":"box","rounding":0.125,"size":[0.1,1e-30,3]})",
  };
  for (const std::string& text : texts) {
    const std::string once = written(shape_of(text));
    CHECK(once == written(shape_of(once)));
    CHECK(parse_json(once)["kind"] == parse_json(text)["kind"]);
  }
  CHECK(written(shape_of(texts[1])) == R"({"kind":"box","size":[0.1,1e-30,3]})");
}

TEST_CASE("shape JSON: a tilted half-space that was written reads back to rounding") {
  std::mt19937 random(1);
  const auto number = [&] { return std::ldexp(static_cast<double>(random()), -31) - 1; };
  for (int i = 0; i < 1000; ++i) {
    const Shape shape(HalfSpace{{number(), number(), number()}, number()});
    const Shape again = shape_of(written(shape));
    CHECK((shape.normal() - again.normal()).norm() <= 4e-16);
    CHECK(std::abs(shape.offset() - again.offset()) <= 4e-16 * std::abs(shape.offset()));
  }
}

TEST_CASE("shape JSON: bad shapes are refused with pointer, value and what is allowed") {
  CHECK(refusal_of_shape(R"({"kind":"box","size":[1,-1,1]})") == "/size/1: -1, allowed: a number > 0");
  CHECK(refusal_of_shape(R"({"kind":"box","size":[1,0,1]})") == "/size/1: 0, allowed: a number > 0");
  CHECK(refusal_of_shape(R"({"kind":"box","size":[1,1]})") == "/size: [1,1], allowed: three numbers [x, y, z]");
  CHECK(refusal_of_shape(R"({"kind":"box","size":[1,"1",1]})") == R"(/size/1: "1", allowed: a number)");
  CHECK(refusal_of_shape(R"({"kind":"sphere","radius":-0.5})") == "/radius: -0.5, allowed: a number >= 0");
  CHECK(refusal_of_shape(R"({"kind":"sphere"})") == "/radius: missing, allowed: a value");
  CHECK(refusal_of_shape(R"({"kind":"sphere","radius":null})") == "/radius: null, allowed: a number >= 0");
  CHECK(refusal_of_shape(R"({"kind":"capsule","radius":0,"length":1})") == "/radius: 0, allowed: a number > 0");
  CHECK(refusal_of_shape(R"({"kind":"cylinder","radius":1,"length":0})") == "/length: 0, allowed: a number > 0");
  CHECK(refusal_of_shape(R"({"kind":"cone","radius":1,"length":-2})") == "/length: -2, allowed: a number > 0");
  CHECK(refusal_of_shape(R"({"kind":"ellipsoid","radii":[1,2,0]})") == "/radii/2: 0, allowed: a number > 0");
  CHECK(refusal_of_shape(R"({"kind":"sphere","radius":1,"size":1})") == "/size: unknown key, allowed: kind, radius, rounding");
  CHECK_THAT(refusal_of_shape(R"({"kind":"ball","radius":1})"),
             Catch::StartsWith(R"(/kind: "ball", allowed: sphere, )"));
  CHECK(refusal_of_shape("3") == "document: 3, allowed: an object");
  CHECK_FALSE(refusal_of_shape(R"({"kind":"halfspace","normal":[0,0,0],"offset":1})").empty());
  CHECK_FALSE(refusal_of_shape(R"({"kind":"sphere","radius":1e300})").empty());
  CHECK(refusal_of_shape(R"({"kind":"convex","vertices":[]})") ==
        "/vertices: [], allowed: one or more points [x, y, z]");
  CHECK_THAT(refusal_of_shape(R"({"kind":"triangle","vertices":[[0,0,0],[1,0,0]]})"), Catch::StartsWith("/vertices: "));
}

TEST_CASE("shape JSON: bad meshes are refused") {
  CHECK(refusal_of_shape(R"({"kind":"mesh","vertices":[[0,0,0],[1,0,0],[0,1,0]],"triangles":[[0,1,3]]})") ==
        "/triangles/0/2: 3, allowed: a whole number, 0 to 2");
  CHECK(refusal_of_shape(R"({"kind":"mesh","vertices":[[0,0,0],[1,0,0],[0,1,0]],"triangles":[[0,1,-1]]})") ==
        "/triangles/0/2: -1, allowed: a whole number, 0 to 2");
  CHECK(refusal_of_shape(R"({"kind":"mesh","vertices":[[0,0,0]],"triangles":[]})") ==
        "/triangles: [], allowed: one or more triangles [i, j, k]");
  CHECK(refusal_of_shape(R"({"kind":"mesh","vertices":[],"triangles":[]})") ==
        "/vertices: [], allowed: one or more points [x, y, z]");
  CHECK_THAT(refusal_of_shape(R"({"kind":"mesh","file":"a.obj","vertices":[]})"), Catch::Contains("both file and"));
  // Open, so it has no interior.
  CHECK_FALSE(
      refusal_of_shape(R"({"kind":"mesh","solid":true,"vertices":[[0,0,0],[1,0,0],[0,1,0]],"triangles":[[0,1,2]]})")
          .empty());
}

TEST_CASE("shape JSON: a mesh file is looked for in the reader's folders, in their order") {
  const TemporaryFolder first, second;
  second.write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Json json = parse_json(R"({"kind":"mesh","file":"one.obj"})");
  ShapeReader reader({first.path(), second.path()});
  CHECK(reader.read(JsonRef(json)).size() == Approx(std::sqrt(2)));
  CHECK_THAT(message_of([&] { ShapeReader({first.path()}).read(JsonRef(json)); }),
             Catch::StartsWith("/file: ") && Catch::Contains("No such file"));
}

TEST_CASE("pose JSON: rows, quaternion or neither") {
  const auto pose = [](std::string_view text) {
    const Json json = parse_json(text);
    return read_pose(JsonRef(json));
  };
  CHECK(pose(R"({"t":[1,2,3]})").rotation == Mat3::Identity());
  CHECK(pose(R"({"t":[1,2,3],"R":[[0,-1,0],[1,0,0],[0,0,1]]})") * Vec3(1, 0, 0) == Vec3(1, 3, 3));
  const double s = std::sqrt(0.5);
  const Mat3 quarter = pose(R"({"t":[0,0,0],"q":[0.707107,0,0,0.707107]})").rotation;
  CHECK((quarter * Vec3(1, 0, 0) - Vec3(0, 1, 0)).norm() < 1e-15);
  CHECK((quarter.transpose() * quarter - Mat3::Identity()).norm() < 1e-15);  // normalised
  CHECK((pose(R"({"t":[0,0,0],"q":[0.70710678,0.70710678,0,0]})").rotation * Vec3(0, s, 0) - Vec3(0, 0, s)).norm() <
        1e-15);
}

TEST_CASE("pose JSON: what is no pose is refused") {
  CHECK_THAT(refusal_of_pose(R"({"t":[0,0,0],"R":[[1,0,0],[0,1,0],[0,0,1]],"q":[1,0,0,0]})"),
             Catch::Contains("both R and q"));
  CHECK_THAT(refusal_of_pose(R"({"t":[0,0,0],"q":[1,0,0,0.01]})"), Catch::StartsWith("/q: [1,0,0,0.01], allowed: "));
  CHECK_FALSE(refusal_of_pose(R"({"t":[0,0,0],"q":[1.0000011,0,0,0]})").empty());
  CHECK(refusal_of_pose(R"({"t":[0,0,0],"q":[1.0000009,0,0,0]})").empty());
  CHECK_FALSE(refusal_of_pose(R"({"t":[0,0,0],"q":[0,0,0,0]})").empty());
  CHECK_FALSE(refusal_of_pose(R"({"t":[0,0,0],"q":[1,0,0]})").empty());
  CHECK_FALSE(refusal_of_pose(R"({"t":[0,0,0],"R":[[1,0,0],[0,1,0],[0,0,-1]]})").empty());  // a mirror
  CHECK_FALSE(refusal_of_pose(R"({"t":[0,0,0],"R":[[2,0,0],[0,1,0],[0,0,1]]})").empty());
  CHECK_FALSE(refusal_of_pose(R"({"t":[0,0,0],"R":[[1,0,0],[0,1,0]]})").empty());
  CHECK(refusal_of_pose(R"({"R":[[1,0,0],[0,1,0],[0,0,1]]})") == "/t: missing, allowed: a value");
  CHECK(refusal_of_pose(R"({"t":[0,0,0],"r":1})") == "/r: unknown key, allowed: t, R, q");
}

TEST_CASE("JSON: numbers that are none and keys that stand twice are refused where they stand") {
  const auto refusal = [](std::string_view text) { return message_of([&] { parse_json(text); }); };
  CHECK(refusal(R"({"pose":{"t":[0,1e999,0]}})") == "/pose/t/1: 1e999, allowed: a number that fits a double");
  CHECK_THAT(refusal(R"({"t":[NaN,0,0]})"), Catch::StartsWith("/t/0: byte 7: syntax error"));
  CHECK_THAT(refusal(R"({"t":[0,Infinity,0]})"), Catch::StartsWith("/t/1: byte "));
  CHECK(refusal(R"({"shapes":{"a":1,"b":2,"a":3}})") == "/shapes/a: the key occurs twice, allowed: once");
  CHECK(refusal(R"([{"x":{}},{"x":[{}, {"a/b":1,"a/b":1}]}])") == "/1/x/1/a~1b: the key occurs twice, allowed: once");
  CHECK_THAT(refusal(R"({"a":)"), Catch::Contains("syntax error"));
  CHECK_FALSE(refusal("").empty());
  CHECK_FALSE(refusal("{} {}").empty());
  CHECK(refusal(R"({"a":{"a":1}, "b":{"a":1}})").empty());
  const std::string deep(1'000'000, '[');
  CHECK_FALSE(refusal(deep).empty());
}

TEST_CASE("JSON: doubles are written so that they read back as the same bits") {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20'000; ++i) {
    const auto x = std::bit_cast<double>(random());
    if (!std::isfinite(x)) continue;
    JsonWriter out;
    out.value(x);
    REQUIRE(std::bit_cast<std::uint64_t>(parse_json(out.text()).get<double>()) == std::bit_cast<std::uint64_t>(x));
  }
  JsonWriter zero;
  zero.value(-0.0);
  CHECK(std::signbit(parse_json(zero.text()).get<double>()));
  JsonWriter out;
  out.begin_array().value(0.1).value(1e22).value(5e-324).value(3.0).end_array();
  CHECK(out.text() == "[0.1,1e+22,5e-324,3]");
  CHECK_THROWS_AS(JsonWriter().value(std::numeric_limits<double>::quiet_NaN()), std::runtime_error);
}
