#include "tandem/formats/mesh_file.h"

#include <cstring>

#include "catch.h"
#include "formats/text_file.h"
#include "message_of.h"
#include "temporary_folder.h"

using namespace tandem;

namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Mesh read(std::string_view name, std::string_view text) {
  const TemporaryFolder folder;
  return read_mesh_file(folder.write(name, text));
}

// What is said about the file, without the folder it lies in.
std::string refusal(std::string_view name, std::string_view text) {
  const TemporaryFolder folder;
  const std::string what = message_of([&] { read_mesh_file(folder.write(name, text)); });
  const std::string prefix = folder.path().string() + "/";
  return what.starts_with(prefix) ? what.substr(prefix.size()) : what;
}

std::string binary_stl(const std::vector<std::array<float, 9>>& facets, std::string_view header = "binary") {
  std::string out(header);
  out.resize(80, ' ');
  const auto put = [&](const auto& value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    out.append(bytes, sizeof value);
  };
  put(static_cast<std::uint32_t>(facets.size()));
  for (const auto& facet : facets) {
    for (int i = 0; i < 3; ++i) put(0.0f);
    for (const float x : facet) put(x);
    put(static_cast<std::uint16_t>(0));
  }
  return out;
}

constexpr std::string_view square_stl =
    "solid a name\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 1 1 0\n"
    "  endloop\n endfacet\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 1 0\n   vertex 0 1 -0\n"
    "  endloop\n endfacet\nendsolid a name\n";

}  // namespace

TEST_CASE("OBJ: polygons become fans from their first corner, in the file's order") {
  const Mesh mesh = read("a.obj",
                         "# comment\nmtllib none.mtl\nv 0 0 0\nv 1 0 0 1.0\r\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n"
                         "o part\ns off\nf 1/1/1 2//1 3/1 4 # quad\nf -4 -3 \\\n -2\n");
  CHECK(mesh.vertices.size() == 4);
  CHECK(mesh.triangles == Triangles{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}});
  CHECK_FALSE(mesh.solid);
}

TEST_CASE("OBJ: coordinates are rounded correctly") {
  const Mesh mesh = read("a.OBJ", "v 0.1 1e-400 -0.07\nv +2.675 1E3 8.41000000000000014e-3\nv 5 6 7\nf 1 2 3");
  CHECK(mesh.vertices[0] == Vec3(0.1, 0, -0.07));
  CHECK(mesh.vertices[1] == Vec3(2.675, 1e3, 8.41000000000000014e-3));
}

TEST_CASE("OBJ: faults are named with their line") {
  CHECK(refusal("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n") == "a.obj:4: vertex 4, allowed: 1 to 3");
  CHECK_THAT(refusal("a.obj", "v 0 0 0\nf 1 2 0\n"), Catch::StartsWith("a.obj:2: '0', allowed: "));
  CHECK(refusal("a.obj", "v 0 0 0\nf -1 -1 -2\n") == "a.obj:2: vertex -2, allowed: at most 1 back");
  CHECK(refusal("a.obj", "v 0 0 0\n\nv 1 nan 0\n") == "a.obj:3: 'nan', allowed: a finite number");
  CHECK(refusal("a.obj", "v 0 0 inf\n") == "a.obj:1: 'inf', allowed: a finite number");
  CHECK(refusal("a.obj", "v 0 0 1e999\n") == "a.obj:1: '1e999', allowed: a finite number");
  CHECK(refusal("a.obj", "v 0 0") == "a.obj:1: '', allowed: three numbers after v");
  CHECK(refusal("a.obj", "v 0 0 0\nf 1 1") == "a.obj:2: '2 corners', allowed: 3 or more corners after f");
  CHECK_THAT(refusal("a.obj", ""), Catch::StartsWith("a.obj: no faces"));
  CHECK_THAT(refusal("a.obj", "v 0 0 0\n"), Catch::StartsWith("a.obj: no faces"));
  CHECK_THAT(refusal("a.ply", ""), Catch::StartsWith("a.ply: extension '.ply', allowed: .obj, .stl"));
}

TEST_CASE("STL: text and binary give the same welded mesh") {
  const Mesh text = read("a.stl", square_stl);
  const Mesh binary = read("a.stl", binary_stl({{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 0, 0, 1, 0}}));
  // Programs exist that begin binary files with the word of the other format.
  const Mesh solid = read("a.stl", binary_stl({{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 0, 0, 1, 0}}, "solid"));
  CHECK(text.triangles == Triangles{{0, 1, 2}, {0, 2, 3}});
  CHECK(binary.triangles == text.triangles);
  CHECK(solid.triangles == text.triangles);
  CHECK(text.vertices == binary.vertices);
  CHECK(text.vertices == std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
}

TEST_CASE("STL: a file cut off anywhere is refused") {
  const std::string binary = binary_stl({{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 0, 0, 1, 0}});
  for (std::size_t size = 0; size < binary.size(); ++size) {
    CAPTURE(size);
    CHECK_FALSE(refusal("a.stl", std::string_view(binary).substr(0, size)).empty());
  }
  // Of the text, the end of the last line's name is no loss.
  for (std::size_t size = 0; size < square_stl.rfind("endsolid") + 8; ++size) {
    CAPTURE(size);
    CHECK_FALSE(refusal("a.stl", square_stl.substr(0, size)).empty());
  }
  CHECK(refusal("a.stl", std::string_view(binary).substr(0, 100)) ==
        "a.stl: byte 100: end of file, allowed: 184 bytes for 2 facets");
  CHECK(refusal("a.stl", square_stl.substr(0, 60)).substr(0, 8) == "a.stl:4:");
}

TEST_CASE("STL: other faults are named") {
  CHECK(refusal("a.stl", binary_stl({})) == "a.stl: byte 80: 0 facets, allowed: one or more");
  CHECK_THAT(refusal("a.stl", binary_stl({{0, 0, NAN, 1, 0, 0, 1, 1, 0}})), Catch::Contains("byte 96: "));
  CHECK_THAT(refusal("a.stl", "solid empty\nendsolid\n"), Catch::Contains("no facets"));
  CHECK_THAT(refusal("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n"),
             Catch::StartsWith("a.stl:4: 'x', allowed: a finite number"));
  CHECK_THAT(refusal("a.stl", "hello"), Catch::StartsWith("a.stl: byte 5: end of file"));
}

TEST_CASE("mesh files: a missing file and a folder in a file's place are refused") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "folder.obj");
  CHECK_THAT(message_of([&] { read_mesh_file(folder / "none.obj"); }),
             Catch::Contains(": No such file or directory, "));
  CHECK_THAT(message_of([&] { read_mesh_file(folder / "folder.obj"); }),
             Catch::EndsWith("a directory, allowed: a file"));
}
