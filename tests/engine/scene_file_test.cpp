// Scene files: reading, writing, errors.
#include "tandem/formats/scene_file.h"
#include "formats/scene_json.h"

#include "catch.h"
#include "formats/pair_record.h"
#include "formats/record_file.h"
#include "formats/text_file.h"
#include "message_of.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"
#include "temporary_folder.h"

using namespace tandem;

namespace {

Scene scene_of(std::string_view text) {
  const Json json = parse_json(text);
  ShapeReader shapes;
  return read_scene(JsonRef(json), shapes);
}

std::string refusal(std::string_view text) {
  return message_of([&] { scene_of(text); });
}

std::string with_body(const std::string& body) {
  return R"({"shapes":{"ball":{"kind":"sphere","radius":1},"ground":{"kind":"halfspace","normal":[0,0,1],"offset":0}},)"
         R"("bodies":[{"shape":"ground","static":true},)" +
         body + "]}";
}

std::string written(const Scene& scene) {
  JsonWriter out;
  write_scene(out, scene);
  return out.text();
}

PipelineOptions sequential() {
  PipelineOptions options;
  options.executor = ExecutorKind::sequential;
  return options;
}

}  // namespace

TEST_CASE("scene file: every key is read") {
  const Scene scene = scene_of(
      R"({"name":"n","gravity":[0,0,-1],"dt":0.5,"request":"distance","shapes":{"ball":{"kind":"sphere","radius":1}},
          "bodies":[{"shape":"ball","pose":{"t":[1,2,3]},"velocity":[4,5,6],"angular_velocity":[7,8,9],"density":10,
                     "continuous":true,"group":2,"mask":4294967295},{"shape":"ball","static":true}]})");
  CHECK(scene.name == "n");
  CHECK(scene.gravity == Vec3(0, 0, -1));
  CHECK(scene.dt == 0.5);
  CHECK(scene.request == Request::distance);
  REQUIRE(scene.bodies() == 2);
  CHECK(scene.poses()[0].translation == Vec3(1, 2, 3));
  CHECK(scene.velocities()[0] == Vec3(4, 5, 6));
  CHECK(scene.angular_velocities()[0] == Vec3(7, 8, 9));
  CHECK(scene.densities()[0] == 10);
  CHECK(scene.groups()[0] == 2);
  CHECK(scene.masks()[0] == 0xffffffffu);
  CHECK(scene.is_static()[0] == 0);
  CHECK(scene.is_static()[1] == 1);
  CHECK(scene.continuous()[0] == 1);
  CHECK(scene.continuous()[1] == 0);
}

TEST_CASE("scene file: no bodies and shapes that no body uses are fine") {
  CHECK(scene_of("{}").bodies() == 0);
  CHECK(scene_of(R"({"shapes":{},"bodies":[]})").bodies() == 0);
  CHECK(scene_of(R"({"shapes":{"unused":{"kind":"sphere","radius":1}},"bodies":[]})").shapes().size() == 1);
}

TEST_CASE("scene file: the page that describes it has every key, and its examples are read") {
  const std::string page = read_file(TANDEM_DOCS "/scene-format.md");
  const TemporaryFolder folder;
  folder.write(
      "part.stl",
      "solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
      "facet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\nendsolid\n");
  std::vector<std::string> examples;
  constexpr std::string_view open = "```json\n";
  for (std::size_t at = page.find(open); at != std::string::npos; at = page.find(open, at)) {
    at += open.size();
    examples.push_back(page.substr(at, page.find("```", at) - at));
  }
  REQUIRE(examples.size() == 2);
  const Scene scene = read_scene_file(folder.write("scene.json", examples[0]));
  CHECK(scene.bodies() == 4);
  CHECK(scene.shapes().back().is_solid());
  ShapeReader shapes;
  CHECK(answer_line(examples[1], 1, shapes, {}).ok);
  const auto check_keys = [&](const std::string& refused) {
    constexpr std::string_view mark = "allowed: ";
    REQUIRE(refused.find(mark) != std::string::npos);
    for (std::size_t at = refused.find(mark) + mark.size(), end; at < refused.size(); at = end + 2) {
      end = std::min(refused.find(", ", at), refused.size());
      const std::string key = refused.substr(at, end - at);
      CAPTURE(key);
      CHECK(page.find('`' + key + '`') != std::string::npos);
    }
  };
  check_keys(refusal(R"({"?":1})"));
  check_keys(refusal(with_body(R"({"?":1})")));
  check_keys(refusal(with_body(R"({"shape":"ball","pose":{"?":1}})")));
  check_keys(refusal(R"({"shapes":{"a":{"kind":"?"}}})"));
  for (const std::string kind :
       {"sphere", "box", "capsule", "cylinder", "cone", "ellipsoid", "halfspace", "convex", "triangle", "mesh",
        "plane"})
    check_keys(refusal(R"({"shapes":{"a":{"kind":")" + kind + R"(","?":1}}})"));
}

TEST_CASE("scene file: faults are refused with the pointer to them") {
  CHECK_THAT(refusal(R"({"title":"x"})"), Catch::StartsWith("/title: unknown key, allowed: name, "));
  CHECK_THAT(refusal(with_body(R"({"shape":"ball","mass":1})")), Catch::StartsWith("/bodies/1/mass: unknown key"));
  CHECK_THAT(refusal(R"({"shapes":{"a":{"kind":"sphere","radius":1,"r":2}}})"),
             Catch::StartsWith("/shapes/a/r: unknown key"));
  CHECK(refusal(with_body(R"({"shape":"bell"})")) == R"(/bodies/1/shape: "bell", allowed: a name in /shapes)");
  CHECK(refusal(with_body(R"({"shape":"ball","density":-1})")) == "/bodies/1/density: -1, allowed: a number > 0");
  CHECK_THAT(refusal(with_body(R"({"shape":"ball","density":1,"static":true})")),
             Catch::StartsWith("/bodies/1: both density and static"));
  CHECK_THAT(refusal(with_body(R"({"shape":"ball","static":1})")), Catch::StartsWith("/bodies/1/static: 1, "));
  CHECK_THAT(refusal(with_body(R"({"shape":"ground"})")), Catch::StartsWith("/bodies/1: "));  // it must be static
  CHECK_THAT(refusal(with_body(R"({"shape":"ball","group":4294967296})")), Catch::StartsWith("/bodies/1/group: "));
  CHECK_THAT(refusal(with_body(R"({"shape":"ball","mask":-1})")), Catch::StartsWith("/bodies/1/mask: -1, "));
  CHECK_THAT(refusal(with_body(R"({"shape":"ball","pose":{"t":[0,0,0],"R":[[1,0,0],[0,1,0],[0,1,0]]}})")),
             Catch::StartsWith("/bodies/1/pose"));
  CHECK_THAT(refusal(with_body("7")), Catch::StartsWith("/bodies/1: 7, allowed: an object"));
  CHECK(refusal(R"({"dt":0})") == "/dt: 0, allowed: a number > 0");
  CHECK(refusal(R"({"gravity":9.81})") == "/gravity: 9.81, allowed: three numbers [x, y, z]");
  CHECK(refusal(R"({"request":"all"})") == R"(/request: "all", allowed: collide, distance, contacts)");
  CHECK_THAT(refusal(R"({"shapes":[]})"), Catch::StartsWith("/shapes: []"));
  CHECK_THAT(refusal(R"({"bodies":{}})"), Catch::StartsWith("/bodies: {}"));
  CHECK_THAT(refusal(R"({"shapes":{"a":{"kind":"sphere","radius":1},"a":{"kind":"sphere","radius":2}}})"),
             Catch::StartsWith("/shapes/a: the key occurs twice"));
}

TEST_CASE("scene file: the file is named, and meshes lie beside it") {
  const TemporaryFolder folder;
  folder.write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string text = R"({"shapes":{"m":{"kind":"mesh","file":"one.obj"}},"bodies":[{"shape":"m"}]})";
  CHECK(read_scene_file(folder.write("good.json", text)).bodies() == 1);
  const auto bad = folder.write("bad.json", R"({"shapes":{"m":{"kind":"mesh","file":"two.obj"}}})");
  CHECK_THAT(message_of([&] { read_scene_file(bad); }),
             Catch::StartsWith(bad.string() + ": /shapes/m/file: ") && Catch::Contains("two.obj: No such file"));
  CHECK_THAT(message_of([&] { read_scene_file(folder.write("cut.json", std::string_view(text).substr(0, 50))); }),
             Catch::Contains("cut.json: ") && Catch::Contains("syntax error"));
  CHECK_THAT(message_of([&] { read_scene_file(folder / "none.json"); }), Catch::Contains("No such file"));
  CHECK_THAT(message_of([&] { read_scene_file(folder.path()); }), Catch::Contains("a directory"));
}

TEST_CASE("scene file: a built-in scene that was written detects the same, bit for bit") {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    CAPTURE(builtin.name);
    Scene made = make_builtin_scene(builtin.name, std::min<std::size_t>(builtin.bodies, 60));
    Scene read = scene_of(written(made));
    const bool same_text = written(read) == written(made);  // as a variable, since the text is too long to print
    CHECK(same_text);
    Pipeline first(sequential()), second(sequential());
    Response first_response, second_response;
    std::uint64_t contacts = 0;
    for (int step = 0; step < 20; ++step) {
      const StepReport expected = first.step(made), found = second.step(read);
      contacts += expected.contacts;
      REQUIRE(found.contact_hash == expected.contact_hash);
      first_response.step(made, first.contacts());
      second_response.step(read, second.contacts());
    }
    CAPTURE(contacts);
  }
}

TEST_CASE("record: the poses replay to the recorded contact hashes") {
  const TemporaryFolder folder;
  Scene scene = make_builtin_scene("complex-in-contact", 4);
  std::vector<std::uint64_t> hashes;
  std::vector<std::size_t> contacts;
  {
    OutputFile file("--record", folder / "r.record");
    RecordWriter writer(file, scene);
    Pipeline pipeline(sequential());
    Response response;
    for (int i = 0; i < 5; ++i) {
      const StepReport report = pipeline.step(scene);
      writer.step(report.step, report.contact_hash, scene, pipeline.contacts());
      hashes.push_back(report.contact_hash);
      contacts.push_back(report.contacts);
      response.step(scene, pipeline.contacts());
    }
    file.commit();
  }
  CHECK(contacts[0] > 0);
  RecordReader reader(folder / "r.record");
  Scene replay = reader.scene();
  Pipeline pipeline(sequential());
  RecordedStep step;
  std::size_t steps = 0;
  for (; reader.next(step); ++steps) {
    for (const auto& [index, pose] : step.poses) replay.set_pose(replay.id(index), pose);
    CHECK(step.step == steps);
    CHECK(step.contact_hash == hashes[steps]);
    CHECK(step.contacts.size() == contacts[steps]);
    CHECK(pipeline.step(replay).contact_hash == hashes[steps]);
  }
  CHECK(steps == 5);
  const std::string whole = read_file(folder / "r.record");
  for (const std::size_t size : {whole.size() - 1, whole.size() / 2, whole.find('\n') + 3, std::size_t{10}}) {
    const auto cut = folder.write("cut.record", std::string_view(whole).substr(0, size));
    CHECK_THAT(message_of([&] {
                 RecordReader broken(cut);
                 while (broken.next(step)) continue;
               }),
               Catch::Contains("cut.record: "));
  }
}

TEST_CASE("scenes with numbers that no reader takes are not written") {
  const TemporaryFolder folder;
  const auto refusal = [&](auto&& change) {
    Scene scene;
    const BodyId body = scene.add_body({.shape = scene.add_shape(Sphere{1})});
    change(scene, body);
    return message_of([&] { write_scene_file(folder / "s.json", scene); });
  };
  CHECK(refusal([](Scene&, BodyId) {}).empty());
  CHECK_THAT(refusal([](Scene& s, BodyId) { s.dt = 0; }), Catch::Contains("dt is 0"));
  CHECK_THAT(refusal([](Scene& s, BodyId) { s.dt = 2e3; }), Catch::Contains("dt is 2000"));
  CHECK_THAT(refusal([](Scene& s, BodyId) { s.gravity.y() = std::nan(""); }), Catch::Contains("gravity[1] is nan"));
  CHECK_THAT(refusal([](Scene& s, BodyId body) { s.set_velocity(body, {2e9, 0, 0}, Vec3::Zero()); }),
             Catch::Contains("body 0: velocity[0] is 2e+09"));
}

TEST_CASE("a record numbers the bodies that there are, and takes no others") {
  const TemporaryFolder folder;
  Scene scene;
  const ShapeId ball = scene.add_shape(Sphere{1});
  std::vector<BodyId> bodies;
  for (const double x : {50.0, 0.0, 1.5})
    bodies.push_back(scene.add_body({.shape = ball, .pose = {Mat3::Identity(), {x, 0, 0}}}));
  scene.remove_body(bodies[0]);
  Pipeline pipeline(sequential());
  {
    OutputFile file("test", folder / "r.record");
    RecordWriter writer(file, scene);
    pipeline.step(scene);
    writer.step(0, hash(pipeline.contacts()), scene, pipeline.contacts());
    const BodyId added = scene.add_body({.shape = ball});
    CHECK_THAT(message_of([&] { writer.step(1, 0, scene, {}); }), Catch::Contains("other bodies"));
    scene.remove_body(added);
    scene.remove_body(bodies[1]);
    CHECK_THAT(message_of([&] { writer.step(1, 0, scene, {}); }), Catch::Contains("other bodies"));
    file.commit();
  }
  RecordReader reader(folder / "r.record");
  Scene replay = reader.scene();
  RecordedStep step;
  REQUIRE(reader.next(step));
  REQUIRE(step.poses.size() == 2);
  CHECK(step.poses[1].first == 1);
  CHECK(step.poses[1].second.translation.x() == 1.5);
  REQUIRE(step.contacts.size() == 1);
  CHECK(step.contacts[0].a == 0);
  CHECK(step.contacts[0].b == 1);
  Pipeline again(sequential());
  again.step(replay);
  CHECK(hash(again.contacts()) == step.contact_hash);
  CHECK(!reader.next(step));
}
