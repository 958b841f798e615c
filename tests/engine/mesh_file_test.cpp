// Readers of mesh files: accepted and refused inputs.
#include "tandem/formats/mesh_file.h"

#include <cstring>
#include <limits>

#include "catch.h"
#include "formats/text_file.h"
#include "message_of.h"
#include "temporary_folder.h"

using namespace tandem;

namespace {

using Points = std::vector<Vec3>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Mesh read(std::string_view name, std::string_view text) {
  const TemporaryFolder folder;
  return read_mesh_file(folder.write(name, text));
}

// The error message, without the folder of the file.
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
  CHECK(refusal("a.obj", "v 0 0") == "a.obj:1: 'end of file', allowed: three numbers after v");
  CHECK(refusal("a.obj", "v 0 0 0\nf 1 1") == "a.obj:2: '2 corners', allowed: 3 or more corners after f");
  CHECK_THAT(refusal("a.obj", ""), Catch::StartsWith("a.obj: no faces"));
  CHECK_THAT(refusal("a.obj", "v 0 0 0\n"), Catch::StartsWith("a.obj: no faces"));
  CHECK(refusal("a.dae", "") == "a.dae: extension '.dae', allowed: .obj, .stl, .ply, .off, .gltf, .glb");
}

TEST_CASE("STL: text and binary give the same welded mesh") {
  const Mesh text = read("a.stl", square_stl);
  const Mesh binary = read("a.stl", binary_stl({{0, 0, 0, 1, 0, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 0, 0, 1, 0}}));
  // Some programs begin binary files with the keyword of the text format.
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
  // In the text, the last line's name may be cut off.
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

namespace {

template <typename T>
std::string bytes_of(T value, bool big_endian = false) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return big_endian ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

std::string binary_ply(bool big) {
  std::string out = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                    "_endian 1.0\nelement vertex 3\nproperty double x\nproperty float y\nproperty short z\n"
                    "property list uchar short seen\nelement face 1\nproperty uchar red\n"
                    "property list int uchar vertex_indices\nend_header\n";
  for (int i = 0; i < 3; ++i)
    out += bytes_of(0.1 * i, big) + bytes_of(0.5f, big) + bytes_of(static_cast<std::int16_t>(-i), big) +
           bytes_of(std::uint8_t{1}) + bytes_of(std::int16_t{7}, big);
  return out + bytes_of(std::uint8_t{255}) + bytes_of(std::int32_t{3}, big) + std::string("\0\1\2", 3);
}

constexpr std::string_view ascii_ply =
    "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement vertex 4\r\nproperty float x\r\nproperty double y\r\n"
    "property float z\r\nproperty uchar red\r\nelement face 2\r\nproperty list uchar int vertex_index\r\n"
    "property list uchar float texcoord\r\nend_header\r\n"
    "0.1 0 0 9\r\n1 0 0 9\r\n1 1 0 9\r\n0 1e-3 0 9\r\n3 0 1 2 0\r\n4 0 1 2 3 2 0.5 0.5\r\n";

/// A triangle with positions in base64, placed by `node`.
std::string gltf(std::string_view node, std::string_view primitive = "", std::string_view more = "") {
  // (0, 0, 0), (1, 0, 0), (0, 1, 0)
  return R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0)" + std::string(node) +
         R"(}],"meshes":[{"primitives":[{"attributes":{"POSITION":0})" + std::string(primitive) +
         R"(}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:;base64,)"
         R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}])" +
         std::string(more) + "}";
}

}  // namespace

TEST_CASE("PLY: text") {
  const Mesh mesh = read("a.ply", ascii_ply);
  CHECK(mesh.vertices == Points{{0.1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1e-3, 0}});
  CHECK(mesh.triangles == Triangles{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("PLY: binary of both byte orders keeps doubles") {
  for (const bool big : {false, true}) {
    const Mesh mesh = read("a.ply", binary_ply(big));
    CHECK(mesh.vertices == Points{{0, 0.5, 0}, {0.1, 0.5, -1}, {0.2, 0.5, -2}});
    CHECK(mesh.triangles == Triangles{{0, 1, 2}});
  }
}

TEST_CASE("PLY: a file cut off anywhere is refused") {
  const std::string binary = binary_ply(false);
  for (std::size_t size = 0; size < binary.size(); ++size)
    CHECK_FALSE(refusal("a.ply", binary.substr(0, size)).empty());
  for (std::size_t size = 0; size < ascii_ply.size() - 5; ++size)
    CHECK_FALSE(refusal("a.ply", ascii_ply.substr(0, size)).empty());
}

TEST_CASE("PLY: faults are named with their line or byte") {
  const std::string head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nproperty int z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n";
  CHECK(refusal("a.ply", "solid") == "a.ply:1: 'solid', allowed: ply");
  CHECK(refusal("a.ply", head + "end_header\n0 0 0\n") ==
        "a.ply: no faces, allowed: an element face with a list vertex_indices");
  CHECK(refusal("a.ply", head + face + "3 0 0 1\n") == "a.ply:11: 'vertex 1', allowed: 0 up to below 1");
  CHECK(refusal("a.ply", head + face + "2 0 0\n") == "a.ply:11: 'a face of 2 corners', allowed: 3 or more");
  CHECK_THAT(refusal("a.ply", head + "property half w\n"), Catch::StartsWith("a.ply:7: 'half', allowed: char, uchar"));
  CHECK(refusal("a.ply", "ply\nelement vertex -1\n") == "a.ply:2: '-1', allowed: a number of elements");
  CHECK(refusal("a.ply", "ply\nelement face 1\nproperty list float int a\n") ==
        "a.ply:3: 'a list counted by fractions', allowed: a whole type");
  std::string nan = binary_ply(false);
  nan.replace(nan.find("end_header\n") + 11, 8, bytes_of(std::numeric_limits<double>::quiet_NaN()));
  CHECK_THAT(refusal("a.ply", nan), Catch::EndsWith("a coordinate that is not finite, allowed: finite numbers"));
  // Numbers of elements that the file does not contain must not take memory or time.
  const std::string many = "element vertex 9223372036854775807\nproperty char x\nproperty char y\nproperty char z\n";
  CHECK_THAT(refusal("a.ply", "ply\nformat binary_little_endian 1.0\nelement none 9223372036854775807\n" + many + face),
             Catch::Contains("end of file"));
}

TEST_CASE("OFF: vertices with and without more, polygons, comments") {
  const Mesh mesh =
      read("a.off", "OFF # corners\n4 2 0\n\n0 0 0\n1 0 0 # second\n1 1 0\n0 0.1 0\n3 0 1 2 255 0 0\n4 0 1 2 3\n");
  CHECK(mesh.vertices == Points{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0.1, 0}});
  CHECK(mesh.triangles == Triangles{{0, 1, 2}, {0, 1, 2}, {0, 2, 3}});
  CHECK(read("a.off", "COFF\n3 1 0\n0 0 0 1 1 1\n1 0 0 1 1 1\n0 1 0 1 1 1\n3 0 1 2\n").vertices.size() == 3);
  CHECK(read("a.off", "OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2").triangles.size() == 1);
  CHECK(read("a.off", "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2").triangles.size() == 1);
}

TEST_CASE("OFF: faults are named with their line") {
  CHECK(refusal("a.off", "4OFF\n") == "a.off:1: '4OFF', allowed: OFF, before it ST, C and N or none");
  CHECK(refusal("a.off", "OFF BINARY\n") == "a.off:1: 'BINARY', allowed: OFF as text");
  CHECK(refusal("a.off", "OFF\n1 1 0\n0 0 0\n3 0 0 1\n") == "a.off:4: 'vertex 1', allowed: 0 to 0");
  CHECK(refusal("a.off", "OFF\n1 1 0\n0 0\n3 0 0 1\n") == "a.off:3: 'end of line', allowed: a finite number");
  CHECK(refusal("a.off", "OFF\n9 1 0\n0 0 0\n") == "a.off:4: 'end of file', allowed: a finite number");
  CHECK_THAT(refusal("a.off", "OFF\n0 0 0\n"), Catch::EndsWith("allowed: one or more of each"));
}

TEST_CASE("glTF: nodes place their meshes, a mirrored one is turned around") {
  CHECK(read("a.gltf", gltf("")).vertices == Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  const Mesh turned = read("a.gltf", gltf(R"(,"rotation":[0,0,1,0],"scale":[2,3,1],"translation":[0,0,5])"));
  CHECK(turned.vertices == Points{{0, 0, 5}, {-2, 0, 5}, {0, -3, 5}});
  CHECK(turned.triangles == Triangles{{0, 1, 2}});
  CHECK(read("a.gltf", gltf(R"(,"scale":[1,1,-1])")).vertices[1] == Vec3(0, 1, 0));
  CHECK(read("a.gltf", gltf(R"(,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,7,8,9,1])")).vertices[1] == Vec3(8, 8, 9));
  CHECK(read("a.gltf", gltf("", R"(,"mode":5)")).triangles == Triangles{{0, 1, 2}});
  CHECK(read("a.gltf", gltf("", R"(,"mode":6)")).triangles == Triangles{{0, 1, 2}});
}

TEST_CASE("glTF: the scene's nodes and a file beside it") {
  const TemporaryFolder folder;
  std::string text = gltf(R"(},{"children":[0],"translation":[1,0,0])", "", R"(,"scenes":[{"nodes":[1]}])");
  const std::size_t begin = text.find("data:"), end = text.find('"', begin);
  text.replace(begin, end - begin, "the%20buffer.bin");
  const auto path = folder.write("a.gltf", text);
  CHECK_THAT(message_of([&] { read_mesh_file(path); }),
             Catch::Contains("a.gltf: /buffers/0/uri: ") && Catch::Contains("the buffer.bin: No such file"));
  std::string bytes;
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) bytes += bytes_of(x);
  folder.write("the buffer.bin", bytes.substr(1));
  CHECK_THAT(message_of([&] { read_mesh_file(path); }), Catch::EndsWith("35 bytes, allowed: a file of 36 and more"));
  folder.write("the buffer.bin", bytes);
  CHECK(read_mesh_file(path).vertices == Points{{1, 0, 0}, {2, 0, 0}, {1, 1, 0}});
}

TEST_CASE("glTF: faults are named with their JSON pointer") {
  CHECK_THAT(refusal("a.gltf", "{}"), Catch::StartsWith("a.gltf: /asset: missing"));
  CHECK(refusal("a.gltf", gltf(R"(,"scale":[1,0,1e308],"translation":[1e308,0,0],"rotation":[0,0,0,0])")) ==
        "a.gltf: /nodes/0/rotation: [0,0,0,0], allowed: a quaternion [x, y, z, w] that is not 0");
  CHECK(refusal("a.gltf", gltf(R"(,"children":[0])")) ==
        "a.gltf: document: no triangles, allowed: a scene with a mesh of triangles");
  CHECK(refusal("a.gltf", gltf(R"(,"children":[0])", "", R"(,"scenes":[{"nodes":[0]}])")) ==
        "a.gltf: /nodes/0: a node in two places, allowed: a tree");
  CHECK_THAT(refusal("a.gltf", gltf("", R"(,"indices":0)")),
             Catch::Contains("/accessors/0/type: \"VEC3\", allowed: SCALAR"));
  CHECK_THAT(refusal("a.gltf", gltf("", "", R"(,"extensionsRequired":["KHR_draco_mesh_compression"])")),
             Catch::StartsWith("a.gltf: /extensionsRequired/0: \"KHR_draco_mesh_compression\", allowed: no required"));
  CHECK(refusal("a.gltf", gltf("", "", R"(,"extensionsRequired":["KHR_materials_unlit"])")).empty());
  std::string long_view = gltf("");
  long_view.replace(long_view.find(R"("count":3)"), 9, R"("count":4000000000)");
  CHECK_THAT(refusal("a.gltf", long_view),
             Catch::Contains("/accessors/0: 48000000000 bytes from byte 0, allowed: what is in its view of 36"));
  CHECK_THAT(refusal("a.glb", "glTF"), Catch::StartsWith("a.glb: byte 4: end of file"));
  CHECK_THAT(refusal("a.glb", "glTF" + bytes_of(1u) + bytes_of(12u)), Catch::StartsWith("a.glb: byte 4: version 1"));
}

TEST_CASE("GLB: JSON and numbers in one file, which may be cut off nowhere") {
  std::string json = gltf("");
  const std::size_t begin = json.find(R"(,"uri")"), end = json.find("}]", begin);
  json.erase(begin, end - begin);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string bytes;
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) bytes += bytes_of(x);
  const std::string chunks = bytes_of(static_cast<std::uint32_t>(json.size())) + "JSON" + json +
                             bytes_of(static_cast<std::uint32_t>(bytes.size())) + std::string("BIN\0", 4) + bytes;
  const std::string glb = "glTF" + bytes_of(2u) + bytes_of(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
  CHECK(read("a.glb", glb).vertices == Points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}});
  CHECK(read("a.gltf", glb).triangles.size() == 1);  // recognised by its beginning
  for (std::size_t size = 0; size < glb.size(); ++size) CHECK_FALSE(refusal("a.glb", glb.substr(0, size)).empty());
}

TEST_CASE("a triangle soup whose edges close is a solid, else its first open edge is named") {
  const std::array<float, 3> v[] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<std::array<float, 9>> facets;
  for (const auto& [i, j, k] : Triangles{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
    std::array<float, 9> facet;
    for (std::size_t x = 0; x < 3; ++x) facet[x] = v[i][x], facet[3 + x] = v[j][x], facet[6 + x] = v[k][x];
    facets.push_back(facet);
  }
  const TemporaryFolder folder;
  CHECK(read_mesh_shape(folder.write("a.stl", binary_stl(facets)), true).is_solid());
  facets.back()[8] = 0.5f;  // a corner no longer equal to another's
  const std::string what = message_of([&] { read_mesh_shape(folder.write("a.stl", binary_stl(facets)), true); });
  CHECK_THAT(what, Catch::EndsWith("a.stl: mesh: solid, but not closed: the edge (0, 1, 0) to (0, 0, 1) of triangle 2 "
                                   "is in 0 one way, in 1 the other, allowed: as many"));
  CHECK_FALSE(read_mesh_shape(folder / "a.stl").is_solid());
}

TEST_CASE("mesh files: a missing file and a folder in a file's place are refused") {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "folder.obj");
  CHECK_THAT(message_of([&] { read_mesh_file(folder / "none.obj"); }),
             Catch::Contains(": No such file or directory, "));
  CHECK_THAT(message_of([&] { read_mesh_file(folder / "folder.obj"); }),
             Catch::EndsWith("a directory, allowed: a file"));
}
