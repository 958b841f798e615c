// Readers with input that is too deep, too long, endless or not text: each is refused with one short line, and nothing
// is read beyond the limits of input_limits.h.
#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <limits>

#include "catch.h"
#include "formats/json_writer.h"
#include "formats/output_file.h"
#include "formats/pair_record.h"
#include "formats/record_file.h"
#include "formats/text_file.h"
#include "message_of.h"
#include "tandem/formats/mesh_file.h"
#include "tandem/formats/octomap_file.h"
#include "tandem/formats/scene_file.h"
#include "temporary_folder.h"

using namespace tandem;

namespace {

constexpr std::size_t long_size = 400'000;

std::string nested(std::size_t depth) { return std::string(depth, '[') + std::string(depth, ']'); }

std::string refusal_of_json(std::string_view text) {
  return message_of([&] { (void)parse_json(text); });
}

std::string refusal_of_scene(std::string_view text) {
  const TemporaryFolder folder;
  return message_of([&] { (void)read_scene_file(folder.write("scene.json", text)); });
}

std::string refusal_of_recording(std::string_view bytes) {
  const TemporaryFolder folder;
  return message_of([&] {
    RecordReader reader(folder.write("a.record", bytes));
    for (RecordedStep step; reader.next(step);) continue;
  });
}

Json answered(std::string_view line) {
  ShapeReader shapes;
  return parse_json(answer_line(line, 1, shapes, {}).text);
}

/// One line, short, of valid UTF-8.
void check_refusal(const std::string& what) {
  CAPTURE(what.substr(0, 1000));
  CHECK_FALSE(what.empty());
  CHECK(what.size() < 300);
  CHECK(std::none_of(what.begin(), what.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }));
  CHECK_NOTHROW(Json(what).dump());
}

template <typename T>
std::string raw_bytes(const T& value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  return {bytes, sizeof(T)};
}

const std::string record_header =
    R"({"format":"tandem-record","version":1,"scene":{"shapes":{"s":{"kind":"sphere","radius":1}},)"
    R"("bodies":[{"shape":"s"}]}})"
    "\n";

std::string step_head(std::uint32_t moving, std::uint32_t contacts) {
  return "STEP" + raw_bytes(std::uint64_t{0}) + raw_bytes(std::uint64_t{0}) + raw_bytes(moving) + raw_bytes(contacts);
}

std::string contact(std::uint32_t a, std::uint32_t b, float depth) {
  std::string out = raw_bytes(a) + raw_bytes(b);
  for (int i = 0; i < 6; ++i) out += raw_bytes(0.5f);
  return out + raw_bytes(depth);
}

}  // namespace

TEST_CASE("readers: a document nested too deep is refused, whatever reads it") {
  CHECK(refusal_of_json(nested(limits::json_depth)).empty());
  for (const std::size_t depth : {limits::json_depth + 1, std::size_t{50'000}, std::size_t{5'000'000}}) {
    CAPTURE(depth);
    check_refusal(refusal_of_json(nested(depth)));
    CHECK_THAT(refusal_of_json(nested(depth)),
               Catch::EndsWith("allowed: at most 64 arrays and objects within each other"));
  }
  check_refusal(refusal_of_scene(R"({"name":)" + nested(50'000) + "}"));
  for (const std::string key : {"id", "shapeA", "note"}) {
    const Json answer = answered(R"({"id":7,")" + key + R"(":)" + nested(50'000) + "}");
    CHECK(answer["status"] == "error");
    check_refusal(answer["error"].get<std::string>());
  }
  std::string objects;
  for (int i = 0; i < 50'000; ++i) objects += R"({"a":)";
  check_refusal(refusal_of_json(objects));
}

TEST_CASE("readers: the values of a document are counted") {
  std::size_t left = 4;
  CHECK(message_of([&] { (void)parse_json("[1,2,3]", nullptr, &left); }).empty());
  CHECK(left == 0);
  left = 3;
  const std::string what = message_of([&] { (void)parse_json("[1,2,3]", nullptr, &left); });
  CHECK_THAT(what, Catch::StartsWith("/2: a document of more values, allowed: at most "));
}

TEST_CASE("readers: a long key, value, number or name is shortened where it is quoted") {
  const std::string long_text(long_size, 'x');
  check_refusal(refusal_of_json(R"({"a":{")" + long_text + R"(":[1,2,nan]}})"));
  check_refusal(refusal_of_json("[" + std::string(long_size, '9') + "e999]"));
  check_refusal(refusal_of_json("[1, " + long_text + "]"));
  check_refusal(refusal_of_json("[\"" + long_text));
  const std::string unknown = refusal_of_scene(R"({"begin)" + long_text + R"(end":1})");
  check_refusal(unknown);
  CHECK_THAT(unknown, Catch::Contains("...") && Catch::Contains("end: unknown key, allowed: name, gravity"));
  check_refusal(refusal_of_scene(R"({"shapes":{")" + long_text + R"(":{"kind":"sphere","radius":-1}}})"));
  check_refusal(refusal_of_scene(R"({"request":")" + long_text + R"("})"));
  check_refusal(refusal_of_scene(R"({"shapes":{"m":{"kind":"mesh","file":")" + long_text + R"(.obj"}}})"));
  check_refusal(refusal_of_scene(R"({"gravity":[)" + std::string(long_size, '1') + R"(,2,3,4]})"));
  check_refusal(answered(R"({"shapeA":{"kind":")" + long_text + R"("}})")["error"].get<std::string>());
  const TemporaryFolder folder;
  check_refusal(message_of([&] { (void)read_mesh_file(folder.write("a.obj", "v 1 2 " + long_text)); }));
  check_refusal(message_of([&] { (void)read_mesh_file(folder.write("a.stl", "solid\n" + long_text)); }));
  check_refusal(message_of([&] { (void)read_mesh_file("a." + long_text); }));
  check_refusal(message_of([&] { (void)read_file("/" + long_text); }));
  CHECK(shortened("abcdefghij", 9) == "abc...hij");
  CHECK(shortened("abc", 9) == "abc");
}

TEST_CASE("readers: bytes that are no text end in a refusal that is") {
  check_refusal(refusal_of_json("[\"\xff\xfe\"]"));
  check_refusal(refusal_of_json("{\"\xc3\":1}"));
  check_refusal(refusal_of_json(std::string_view("[1\0]", 4)));
  check_refusal(refusal_of_json("{\"a\n\":1}"));
  check_refusal(refusal_of_json("\xff\xfe[\0]\0"));
  check_refusal(refusal_of_scene(R"({"a\nb\u0000\u2028":1})"));
  check_refusal(refusal_of_scene(R"({"shapes":{"m":{"kind":"mesh","file":"a.txt\u0000.obj"}}})"));
  CHECK_THAT(refusal_of_scene(R"({"shapes":{"m":{"kind":"mesh","file":"a.txt\u0000.obj"}}})"),
             Catch::Contains("a zero byte"));
  check_refusal(answered("{\"id\":\"\xff\"}")["error"].get<std::string>());
  check_refusal(answered("[NaN]")["error"].get<std::string>());
  CHECK(on_one_line("\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80") == "\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80");
  CHECK(on_one_line("a\nb\x7f\xc2\x85"
                    "c") == "a b  c");
  // Overlong, a surrogate, beyond the last character, truncated, a lone continuation byte.
  CHECK(on_one_line("\xc0\x80\xed\xa0\x80\xf4\x90\x80\x80\xe2\x82\x80x\xbf") == "?????????\xe2\x82\x80x?");
  CHECK(on_one_line("\xe2\x82") == "??");
}

TEST_CASE("readers: a byte order mark is passed over") {
  const TemporaryFolder folder;
  const std::string mark = "\xef\xbb\xbf", obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  CHECK(refusal_of_scene(mark + R"({"name":"x"})").empty());
  CHECK(read_mesh_file(folder.write("a.obj", mark + obj)).vertices.size() == 3);
  const std::string stl =
      "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
  CHECK(read_mesh_file(folder.write("a.stl", mark + stl)).triangles.size() == 1);
}

TEST_CASE("readers: a device that never ends is read up to a bound") {
  const std::string whole = message_of([] { (void)read_file("/dev/zero", 1 << 20); });
  CHECK_THAT(whole, Catch::StartsWith("/dev/zero: ") && Catch::EndsWith("allowed: at most 1 MiB"));
  check_refusal(whole);
  InputFile zeros("/dev/zero");
  std::string line;
  CHECK(zeros.line(line, 100) == InputFile::Line::too_long);
  CHECK(line.size() == 100);
  CHECK(zeros.line(line, 100) == InputFile::Line::none);
  CHECK_THAT(message_of([] { RecordReader reader("/dev/zero"); }),
             Catch::Contains("a pipe or device, allowed: a regular file"));
}

TEST_CASE("readers: a pipe without a writer is refused where a mesh, a buffer or a recording must be, not waited for") {
  const TemporaryFolder folder;
  for (const char* name : {"pipe.obj", "pipe.bin", "pipe.record"})
    REQUIRE(::mkfifo((folder / name).c_str(), 0600) == 0);
  const auto refused = [](const std::string& what) {
    check_refusal(what);
    CHECK_THAT(what, Catch::EndsWith("a pipe or device, allowed: a regular file"));
  };
  refused(message_of([&] { RecordReader reader(folder / "pipe.record"); }));
  const auto scene = folder.write("s.json", R"({"shapes":{"m":{"kind":"mesh","file":"pipe.obj"}}})");
  const std::string named = message_of([&] { (void)read_scene_file(scene); });
  refused(named);
  CHECK_THAT(named, Catch::Contains("s.json: /shapes/m/file: "));
  const auto gltf = folder.write("a.gltf", R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":)"
                                           R"([{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,)"
                                           R"("componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":)"
                                           R"([{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,)"
                                           R"("uri":"pipe.bin"}]})");
  const std::string buffer = message_of([&] { (void)read_mesh_file(gltf); });
  refused(buffer);
  CHECK_THAT(buffer, Catch::Contains("/buffers/0/uri: "));
  CHECK_THAT(message_of([&] { (void)read_mesh_file(folder / "pipe.bin"); }), Catch::Contains("extension '.bin'"));
}

TEST_CASE("readers: a line that is too long is passed over and the next one read") {
  const TemporaryFolder folder;
  InputFile file(folder.write("lines", "short\n" + std::string(200'000, 'x') + "\n\nlast"));
  std::string line;
  CHECK(file.line(line, 1000) == InputFile::Line::read);
  CHECK(line == "short");
  CHECK(file.line(line, 1000) == InputFile::Line::too_long);
  CHECK(line == std::string(1000, 'x'));
  CHECK(file.line(line, 1000) == InputFile::Line::read);
  CHECK(line.empty());
  CHECK(file.line(line, 1000) == InputFile::Line::read);
  CHECK(line == "last");
  CHECK(file.line(line, 1000) == InputFile::Line::none);
  CHECK(file.position() == 5 + 1 + 200'000 + 1 + 1 + 4);
}

TEST_CASE("readers: a file larger than its bound is refused by its size") {
  const TemporaryFolder folder;
  const auto sparse = folder.write("a.obj", "v 0 0 0\n");
  std::filesystem::resize_file(sparse, limits::mesh_bytes + 1);
  CHECK_THAT(message_of([&] { (void)read_mesh_file(sparse); }), Catch::EndsWith("4096 MiB, allowed: at most 4096 MiB"));
  std::filesystem::resize_file(sparse, limits::document_bytes + limits::mebibyte);
  CHECK_THAT(message_of([&] { (void)read_scene_file(sparse); }),
             Catch::EndsWith("1025 MiB, allowed: at most 1024 MiB"));
}

TEST_CASE("readers: numbers of triangles and steps that the file does not have take no memory") {
  const TemporaryFolder folder;
  const std::string stl = std::string(80, ' ') + raw_bytes(0xffffffffu) + std::string(50, '\0');
  CHECK_THAT(message_of([&] { (void)read_mesh_file(folder.write("a.stl", stl)); }),
             Catch::EndsWith("byte 134: end of file, allowed: 214748364834 bytes for 4294967295 facets"));
  CHECK(refusal_of_recording(record_header).empty());
  const std::string poses = refusal_of_recording(record_header + step_head(0xffffffffu, 0));
  CHECK_THAT(poses, Catch::EndsWith("4294967295 bodies that move, allowed: at most 1"));
  const std::string contacts = refusal_of_recording(record_header + step_head(0, 0xffffffffu));
  CHECK_THAT(contacts, Catch::EndsWith("4294967295 contacts, allowed: at most 67108864"));
  const std::string few = refusal_of_recording(record_header + step_head(0, 1000));
  CHECK_THAT(few, Catch::Contains("end of file within a step, allowed: 36000 bytes of contacts from byte "));
  for (const std::string& what : {poses, contacts, few}) check_refusal(what);
}

TEST_CASE("readers: a recorded contact names bodies and finite numbers") {
  CHECK(refusal_of_recording(record_header + step_head(0, 1) + contact(0, 0, 1)).empty());
  check_refusal(refusal_of_recording(record_header + step_head(0, 1) + contact(0, 1, 1)));
  CHECK_THAT(refusal_of_recording(record_header + step_head(0, 1) + contact(0, 1, 1)),
             Catch::EndsWith("body 1, allowed: below 1"));
  for (const float x : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
    CHECK_THAT(refusal_of_recording(record_header + step_head(0, 1) + contact(0, 0, x)),
               Catch::EndsWith("allowed: finite numbers"));
}

TEST_CASE("readers: a step's bodies are in order, none twice") {
  const std::string header = R"({"format":"tandem-record","version":1,"scene":{"shapes":{"s":{"kind":"sphere",)"
                             R"("radius":1}},"bodies":[{"shape":"s"},{"shape":"s"}]}})"
                             "\n";
  const auto pose = [](std::uint32_t body) {
    std::string out = raw_bytes(body);
    for (const double x : {0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1.}) out += raw_bytes(x);
    return out;
  };
  CHECK(refusal_of_recording(header + step_head(2, 0) + pose(0) + pose(1)).empty());
  for (const std::uint32_t first : {0u, 1u}) {
    const std::string what = refusal_of_recording(header + step_head(2, 0) + pose(first) + pose(0));
    check_refusal(what);
    CHECK_THAT(what, Catch::EndsWith("body 0 after body " + std::to_string(first) +
                                     ", allowed: each body once, by their numbers"));
  }
}

TEST_CASE("readers: the corners of all uses of a glTF file's meshes are counted, those of turning strips, too") {
  const TemporaryFolder folder;
  constexpr std::size_t corners = std::size_t{1} << 20;
  std::string bytes(36 + corners, '\0');
  bytes[14] = bytes[32] = '\x80', bytes[15] = bytes[33] = '\x3f';  // (0, 0, 0), (1, 0, 0), (0, 1, 0), then indices 0
  (void)folder.write("a.bin", bytes);
  const auto refusal = [&](std::size_t uses) {
    std::string nodes = R"({"mesh":0})";
    for (std::size_t i = 1; i < uses; ++i) nodes += R"(,{"mesh":0})";
    return message_of([&] {
      (void)read_mesh_file(folder.write(
          "a.gltf", R"({"asset":{"version":"2.0"},"nodes":[)" + nodes +
                        R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":5}]}],)"
                        R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
                        R"({"bufferView":0,"byteOffset":36,"componentType":5121,"count":1048576,"type":"SCALAR"}],)"
                        R"("bufferViews":[{"buffer":0,"byteLength":1048612}],)"
                        R"("buffers":[{"byteLength":1048612,"uri":"a.bin"}]})"));
    });
  };
  CHECK_THAT(refusal(2), Catch::EndsWith("document: no triangles, allowed: a scene with a mesh of triangles"));
  const std::size_t most = limits::mesh_vertices / corners;
  const std::string what = refusal(most + 1);
  check_refusal(what);
  CHECK_THAT(what, Catch::EndsWith("/nodes/" + std::to_string(most) + ": one more use of a mesh, allowed: at most " +
                                   std::to_string(limits::mesh_vertices) + " corners in all"));
}

TEST_CASE("readers: an object in a glTF file's lists has a bounded number of members") {
  const TemporaryFolder folder;
  std::string members;
  for (std::size_t i = 0; i < limits::gltf_members; ++i) members += R"("x)" + std::to_string(i) + R"(":0,)";
  const std::string what = message_of([&] {
    (void)read_mesh_file(
        folder.write("a.gltf", R"({"asset":{"version":"2.0"},"nodes":[{)" + members + R"("mesh":0}],"meshes":[{}]})"));
  });
  check_refusal(what);
  CHECK_THAT(what, Catch::EndsWith("/nodes/0: 1001 members, allowed: at most 1000"));
}

TEST_CASE("output files: a name that is none, or too long for the system, is refused in a short line") {
  const std::string long_name(5000, 'x');
  for (const std::string& name : {std::string(), std::string("a\0b", 3), long_name, "folder/" + long_name + "\n"}) {
    CHECK_THROWS_AS(OutputFile("--json", name), std::invalid_argument);
    check_refusal(message_of([&] { OutputFile file("--json", name); }));
  }
  check_refusal(message_of([&] { require_different({{"--json", long_name}, {"--trace", long_name}}); }));
}

TEST_CASE("readers: a face that names a vertex too far back or beyond all is refused with its line") {
  const TemporaryFolder folder;
  const auto refusal = [&](std::string_view text) {
    return message_of([&] { (void)read_mesh_file(folder.write("a.obj", text)); });
  };
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  CHECK_THAT(refusal(vertices + "f 1 2 -4\n"), Catch::EndsWith("a.obj:4: vertex -4, allowed: at most 3 back"));
  CHECK_THAT(refusal(vertices + "f 1 2 3\nf 1 5 9\nf 1 2 3\nv 1 1 1\n"),
             Catch::EndsWith("a.obj:5: vertex 5, allowed: 1 to 4"));
  CHECK_THAT(refusal(vertices + "f 1 2 9223372036854775807\n"), Catch::Contains("'9223372036854775807', allowed: "));
  CHECK(refusal(vertices + "f 1 2 4\nv 1 1 1\n").empty());
  CHECK_THAT(refusal("f 1 2 3\n"), Catch::EndsWith("a.obj:1: vertex 1, allowed: none: there are no vertices"));
}

namespace {

Voxels octree(std::string_view header, std::string_view nodes, bool is_binary = true) {
  const TemporaryFolder folder;
  const std::string first = is_binary ? "# Octomap OcTree binary file\n" : "# Octomap OcTree file\n";
  return read_octomap_file(folder.write("map", first + std::string(header) + std::string(nodes)));
}

std::string refusal_of_octree(std::string_view header, std::string_view nodes, bool is_binary = true) {
  const std::string what = message_of([&] { (void)octree(header, nodes, is_binary); });
  check_refusal(what);
  return what;
}

/// A node of an .ot file.
std::string full_node(float odds, int children) { return raw_bytes(odds) + static_cast<char>(children); }

constexpr std::string_view octree_header = "id OcTree\nsize 2\nres 0.5\ndata\n";

}  // namespace

TEST_CASE("octomap: headers with comments and blanks behind their values are read, others refused by name") {
  const std::string_view leaf("\x02\x00", 2);
  for (const std::string_view header :
       {octree_header, std::string_view("# made by hand\n\nid OcTree \nsize 2 \nres 0.5 \ndata \n"),
        std::string_view("id OcTree\r\nres 0.5\t\r\ndata\r\n"), std::string_view("res 0.5\ndata\n")}) {
    CAPTURE(header);
    const Voxels map = octree(header, leaf);
    CHECK(map.cell_size == 0.5);
    REQUIRE(map.cells.size() == 1);
    CHECK(map.cells[0] == VoxelCell{{-32768, -32768, -32768}, 15});
  }
  for (const std::string_view res : {"nan", "inf", "-1", "0", "1e400", "0.5 m", ""}) {
    CAPTURE(res);
    const std::string header = "id OcTree\nres " + std::string(res) + "\ndata\n";
    CHECK_THAT(refusal_of_octree(header, leaf), Catch::Contains("byte 39: ") && Catch::Contains("res"));
  }
  CHECK_THAT(refusal_of_octree("id OcTree\ndata\n", leaf), Catch::Contains("no res"));
  CHECK_THAT(refusal_of_octree("id ColorOcTree\nres 1\ndata\n", leaf), Catch::Contains("ColorOcTree"));
  CHECK_THAT(refusal_of_octree("id OcTree\nres 1\n", leaf), Catch::Contains("end of file"));
  CHECK(octree("id OcTree\nsize 0\nres 1\ndata\n", "").cells.empty());
}

TEST_CASE("octomap: nodes that end early, go on, or lie below level 16 are refused") {
  CHECK_THAT(refusal_of_octree(octree_header, "\x02"), Catch::Contains("end of file"));
  CHECK_THAT(refusal_of_octree(octree_header, ""), Catch::Contains("end of file"));
  CHECK_THAT(refusal_of_octree(octree_header, std::string(5, '\0')), Catch::Contains("3 bytes behind the tree"));
  // A chain of nodes: the last has leaves of the smallest size, or one more node.
  const std::string_view inner("\x03\x00", 2), leaf("\x02\x00", 2);
  std::string chain, full;
  for (int level = 16; level > 1; --level) chain += inner, full += full_node(0, 1);
  const Voxels deep = octree(octree_header, chain + std::string(leaf));
  REQUIRE(deep.cells.size() == 1);
  CHECK(deep.cells[0].level == 0);
  CHECK_THAT(refusal_of_octree(octree_header, chain + std::string(inner) + std::string(leaf)),
             Catch::Contains("below level 16"));
  full += full_node(0, 1);
  CHECK(octree(octree_header, full + full_node(0.5f, 0), false).cells == deep.cells);
  CHECK(octree(octree_header, full + full_node(-0.5f, 0), false).cells.empty());
  CHECK_THAT(refusal_of_octree(octree_header, full + full_node(0, 1) + full_node(0, 0), false),
             Catch::Contains("below level 16"));
  CHECK_THAT(refusal_of_octree(octree_header, full_node(0, 1), false), Catch::Contains("end of file"));
}

TEST_CASE("octomap: a device that never ends is refused by its first bytes") {
  CHECK_THAT(message_of([] { (void)read_octomap_file("/dev/zero"); }), Catch::Contains("/dev/zero: byte 0"));
  CHECK_FALSE(message_of([] { (void)read_octomap_file("/nowhere/map.bt"); }).empty());
}
