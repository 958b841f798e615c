// Runs the program `tandem` like a user's script. Its path is TANDEM_PROGRAM in the environment, or TANDEM_PROGRAM_PATH
// of the build.
#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "catch.h"
#include "formats/json_reader.h"
#include "formats/text_file.h"
#include "gzip.h"
#include "temporary_folder.h"

using namespace tandem;

namespace {

std::string program() {
  if (const char* path = std::getenv("TANDEM_PROGRAM")) return path;
#ifdef TANDEM_PROGRAM_PATH
  return TANDEM_PROGRAM_PATH;
#else
  throw std::runtime_error("TANDEM_PROGRAM is not set");
#endif
}

struct Ended {
  int status = -1;  // 128 + the signal if one ended it
  std::string out, err;
};

struct Streams {
  std::string in = "/dev/null";
  std::string out = {};  // empty: collected in Ended::out
  bool close_out = false;
};

Ended tandem_program(const std::vector<std::string>& arguments, const Streams& streams = {}) {
  const TemporaryFolder folder;
  const std::string out = streams.out.empty() ? (folder / "out").string() : streams.out;
  const std::string err = (folder / "err").string();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, streams.in.c_str(), O_RDONLY, 0);
  if (streams.close_out)
    posix_spawn_file_actions_addclose(&actions, 1);
  else
    posix_spawn_file_actions_addopen(&actions, 1, out.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, err.c_str(), O_WRONLY | O_CREAT, 0600);
  std::vector<std::string> words{program()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::pid_t child = 0;
  const int failed = ::posix_spawn(&child, words[0].c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw std::runtime_error(words[0] + " does not start");
  int status = 0;
  ::waitpid(child, &status, 0);
  Ended ended;
  ended.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (streams.out.empty() && !streams.close_out) ended.out = read_file(out);
  ended.err = read_file(err);
  return ended;
}

std::vector<Json> json_lines(const std::string& text) {
  std::vector<Json> out;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    REQUIRE(end != std::string::npos);
    out.push_back(parse_json(std::string_view(text).substr(begin, end - begin)));
    begin = end + 1;
  }
  return out;
}

std::vector<std::string> names_in(const TemporaryFolder& folder) {
  std::vector<std::string> out;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    out.push_back(entry.path().filename().string());
  std::sort(out.begin(), out.end());
  return out;
}

// Checks a refused request: the status, one line that contains the given names, no result.
void check_refused(const std::vector<std::string>& arguments, std::initializer_list<std::string> named,
                   int status = 2) {
  const Ended ended = tandem_program(arguments);
  CAPTURE(arguments);
  CHECK(ended.status == status);
  CHECK(ended.out.empty());
  CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
  for (const std::string& part : named) CHECK_THAT(ended.err, Catch::Contains(part));
}

const std::vector<std::string> small_run{"run", "spheres-on-plane", "--bodies", "20", "--steps", "3"};

std::vector<std::string> small_run_with(std::initializer_list<std::string> more) {
  std::vector<std::string> out = small_run;
  out.insert(out.end(), more.begin(), more.end());
  return out;
}

std::string record(const std::string& id, const std::string& shape, const std::string& pose = R"({"t":[0,0,0]})") {
  return R"({"id":")" + id + R"(","shapeA":)" + shape + R"(,"poseA":)" + pose +
         R"(,"shapeB":{"kind":"sphere","radius":1},"poseB":{"t":[0,0,0]},"ask":["collide"]})" + "\n";
}

}  // namespace

TEST_CASE("program: help, version and lists come on stdout") {
  for (const auto& arguments : std::vector<std::vector<std::string>>{{"--help"},
                                                                     {"run", "--help"},
                                                                     {"query", "--help"},
                                                                     {"scenes", "--help"},
                                                                     {"--version"},
                                                                     {"scenes"},
                                                                     {"query", "--list-solvers"}}) {
    const Ended ended = tandem_program(arguments);
    CAPTURE(arguments);
    CHECK(ended.status == 0);
    CHECK_FALSE(ended.out.empty());
    CHECK(ended.err.empty());
  }
  CHECK_THAT(tandem_program({"scenes"}).out, Catch::Contains("spheres-on-plane"));
  CHECK_THAT(tandem_program({"run", "--help"}).out, Catch::Contains("--executor"));
}

TEST_CASE("program: a wrong request is one line that names the option, the value and what is allowed") {
  check_refused({}, {"run", "query", "scenes"});
  check_refused({"fly"}, {"'fly'", "run, query, clash, inspect, scenes"});
  check_refused({"clash", "nowhere"}, {"there is no file or folder 'nowhere'"});
  check_refused({"clash"}, {"'0 files'", "at least two, or a folder"});
  check_refused({"inspect", "nowhere.stl"}, {"nowhere.stl", "No such file"});
  check_refused({"run"}, {"SCENE"});
  check_refused({"run", "nofile.json"}, {"SCENE", "there is no file 'nofile.json'"});
  const TemporaryFolder meshes;
  check_refused({"run", meshes.write("a.ply", "ply")}, {"SCENE", "is a mesh"});
  check_refused({"run", "no-such-scene"}, {"'no-such-scene'", "spheres-on-plane", "tori-on-cones"});
  check_refused({"run", "line\nbreak"}, {"spheres-on-plane"});
  check_refused(small_run_with({"--fast"}), {"--fast"});
  check_refused(small_run_with({"--seed"}), {"--seed"});
  check_refused(small_run_with({"--threads", "-1"}), {"--threads", "'-1'", "0 to 1024"});
  check_refused(small_run_with({"--threads", "1025"}), {"--threads", "'1025'", "0 to 1024"});
  check_refused(small_run_with({"--threads", "99999999999999999999"}), {"--threads", "0 to 1024"});
  check_refused(small_run_with({"--threads", "two"}), {"--threads", "'two'"});
  check_refused(small_run_with({"--threads", "4", "--split", "1-2"}), {"--split", "'1-2'", "4"});
  for (const std::string split : {"0-2", "2-0", "1", "1-2-3", "-", "a-b", "1000-1000", "1- 1"})
    check_refused(small_run_with({"--split", split}), {"--split", "'" + split + "'", "X-Y"});
  check_refused(small_run_with({"--executor", "gpu"}), {"--executor", "'gpu'", "sequential, barrier"});
  check_refused(small_run_with({"--broadphase", "octree"}), {"--broadphase", "'octree'", "brute, sweep"});
  check_refused(small_run_with({"--request", "all"}), {"--request", "'all'", "collide, distance, contacts"});
  check_refused(small_run_with({"--balance", "x"}), {"--balance", "'x'", "paper, busy"});
  for (const std::string tolerance : {"nan", "inf", "-1", "1", "1e999", ""})
    check_refused(small_run_with({"--tolerance", tolerance}), {"--tolerance", "'" + tolerance + "'", "0 to 0.1"});
  check_refused(small_run_with({"--margin", "nan"}), {"--margin", "'nan'"});
  check_refused({"run", "spheres-on-plane", "--steps", "0"}, {"--steps", "'0'"});
  check_refused({"run", "spheres-on-plane", "--bodies", "0"}, {"--bodies", "'0'"});
  check_refused({"run", "spheres-on-plane", "--bodies", "100000000"}, {"--bodies", "1000000"});
  check_refused({"query"}, {"FILE"});
  check_refused({"query", "/no/such/file"}, {"/no/such/file", "No such file"});
  check_refused({"query", "/tmp"}, {"/tmp"});
  check_refused({"query", "-", "--solver", "magic"}, {"--solver", "'magic'", "allowed: "});
  check_refused({"query", "-", "--tolerance", "2"}, {"--tolerance", "'2'"});
  check_refused({"query", "-", "--meshes", "/no/such/folder"}, {"--meshes"});
  check_refused({"scenes", "spheres-on-plane"}, {"--write"});
  check_refused({"scenes", "nothing", "--write", "/dev/null"}, {"nothing", "spheres-on-plane"});
}

TEST_CASE("program: a bad scene file is one line with file and pointer") {
  const TemporaryFolder folder;
  const auto refused = [&](std::string_view text, std::initializer_list<std::string> named) {
    check_refused({"run", folder.write("s.json", text).string()}, named);
  };
  const std::string ball = R"("shapes":{"ball":{"kind":"sphere","radius":1}},)";
  refused("{" + ball + R"("bodies":[{"shape":"ball","pose":{"t":[NaN,0,0]}}]})", {"s.json", "/bodies/0/pose/t/0"});
  refused("{" + ball + R"("bodies":[{"shape":"ball","pose":{"t":[1e999,0,0]}}]})", {"/bodies/0/pose/t/0: 1e999"});
  refused("{" + ball + R"("bodies":[{"shape":"ball","pose":{"t":[0,0,0],"R":[[1,1,0],[0,1,0],[0,0,1]]}}]})",
          {"/bodies/0/pose"});
  refused("{" + ball + R"("bodies":[{"shape":"ball","colour":1}]})", {"/bodies/0/colour: unknown key"});
  refused(R"({"shapes":{"a":{"kind":"sphere","radius":-1}}})", {"/shapes/a/radius: -1, allowed: a number >= 0"});
  refused(R"({"shapes":{"a":{"kind":"box","size":[1,0,1]}}})", {"/shapes/a/size/1: 0, allowed: a number > 0"});
  refused(R"({"shapes":{"a":{"kind":"convex","vertices":[]}}})", {"/shapes/a/vertices: []"});
  refused(R"({"shapes":{"a":{"kind":"mesh","vertices":[[0,0,0]],"triangles":[[0,0,1]]}}})",
          {"/shapes/a/triangles/0/2: 1"});
  refused(R"({"shapes":{"a":{"kind":"mesh","vertices":[],"triangles":[]}}})", {"/shapes/a/vertices: []"});
  refused(R"({"shapes":{"a":{"kind":"sphere","radius":1},"a":{"kind":"sphere","radius":1}}})",
          {"/shapes/a: the key occurs twice"});
  refused(R"({"shapes":)", {"s.json: ", "syntax error"});
  refused("", {"s.json: "});
  check_refused({"run", folder.path().string()}, {"a directory"});
  const std::string good = folder.write("good.json", "{" + ball + R"("bodies":[{"shape":"ball"}]})").string();
  check_refused({"run", good, "--bodies", "5"}, {"--bodies", "built-in"});
  check_refused({"run", good, "--seed", "5"}, {"--seed", "built-in"});
}

TEST_CASE("program: an unused shape and no bodies run") {
  const TemporaryFolder folder;
  for (const char* text : {"{}", R"({"shapes":{"unused":{"kind":"sphere","radius":1}},"bodies":[]})"}) {
    const Ended ended = tandem_program({"run", folder.write("s.json", text).string(), "--steps", "2"});
    CHECK(ended.status == 0);
    CHECK(ended.err.empty());
    CHECK_THAT(ended.out, Catch::Contains("0 bodies"));
  }
}

TEST_CASE("program: a run writes its four files, with the same contacts for any executor") {
  const TemporaryFolder folder;
  std::vector<std::string> hashes;
  for (const std::string executor : {"sequential", "barrier", "threads", "flowgraph"}) {
    CAPTURE(executor);
    const std::string json = (folder / (executor + ".jsonl")).string();
    const Ended ended =
        tandem_program({"run", "complex-in-contact", "--bodies", "4", "--steps", "3", "--executor", executor,
                        "--threads", "2", "--json", json, "--contacts", (folder / "contacts.jsonl").string(), "--trace",
                        (folder / "trace.json").string(), "--record", (folder / "run.record").string()});
    REQUIRE(ended.status == 0);
    CHECK(ended.err.empty());
    const std::vector<Json> steps = json_lines(read_file(json));
    const std::vector<Json> contacts = json_lines(read_file(folder / "contacts.jsonl"));
    REQUIRE(steps.size() == 3);
    REQUIRE(contacts.size() == 3);
    std::string run_hashes;
    for (std::size_t i = 0; i < 3; ++i) {
      std::vector<std::string> keys;
      for (const auto& [key, value] : steps[i].items()) keys.push_back(key);
      keys.resize(11);
      CHECK(keys == std::vector<std::string>{"step", "bodies", "candidate_pairs", "colliding_pairs", "contacts",
                                             "contact_hash", "split", "control_step", "max_depth", "kinetic_energy",
                                             "ms"});
      CHECK(steps[i]["step"] == i);
      const Json& serial = steps[i]["serial"];
      CHECK(serial.size() == 6);
      CHECK(serial["share"] >= 0);
      CHECK(serial["share"] <= 1);
      CHECK(serial["response_ms"] > 0);
      CHECK(serial["response_ms"] <= steps[i]["ms"]["response"]);
      CHECK(steps[i]["ms"]["busy"] > 0);
      CHECK(contacts[i]["step"] == i);
      CHECK(contacts[i]["contacts"].size() == steps[i]["contacts"].get<std::size_t>());
      run_hashes += steps[i]["contact_hash"].get<std::string>();
    }
    CHECK(steps[0]["contacts"].get<int>() > 0);
    CHECK_THAT(ended.out, Catch::Contains(steps[2]["contact_hash"].get<std::string>()));
    hashes.push_back(run_hashes);
    CHECK(parse_json(read_file(folder / "trace.json")).is_object());
  }
  CHECK(std::count(hashes.begin(), hashes.end(), hashes[0]) == 4);
  CHECK(names_in(folder) == std::vector<std::string>{"barrier.jsonl", "contacts.jsonl", "flowgraph.jsonl", "run.record",
                                                     "sequential.jsonl", "threads.jsonl", "trace.json"});
}

TEST_CASE("program: a scene that was written runs as the built-in one does") {
  const TemporaryFolder folder;
  const std::string file = (folder / "s.json").string();
  REQUIRE(tandem_program({"scenes", "cubes-on-plane", "--bodies", "30", "--write", file}).status == 0);
  const Ended from_file = tandem_program({"run", file, "--steps", "30"});
  const Ended built_in = tandem_program({"run", "cubes-on-plane", "--bodies", "30", "--steps", "30"});
  const auto hash = [](const Ended& ended) { return ended.out.substr(ended.out.find("contact hash"), 33); };
  CHECK(from_file.status == 0);
  CHECK(hash(from_file) == hash(built_in));
}

TEST_CASE("program: output that cannot be written fails before or after the work, with nothing half-written") {
  const TemporaryFolder folder;
  const std::string old = folder.write("old.jsonl", "old").string();
  for (const std::string option : {"--json", "--contacts", "--trace", "--record"}) {
    check_refused(small_run_with({option, folder.path().string()}), {option, "a directory"});
    check_refused(small_run_with({option, (folder / "no/such/folder").string()}), {option, "No such file"});
    check_refused(small_run_with({option, "/dev/full"}), {option, "/dev/full: No space left on device"}, 1);
    // The other file could be written, but the run as a whole failed.
    check_refused(small_run_with({option == "--json" ? "--contacts" : "--json", old, option, "/dev/full"}),
                  {option, "/dev/full"}, 1);
  }
  check_refused(small_run_with({"--json", old, "--contacts", folder.path().string() + "/./old.jsonl"}),
                {"--contacts", "the same file as --json"});
  check_refused(small_run_with({"--request", "collide", "--contacts", old}), {"--contacts", "'collide'"});
  const std::string scene = folder.write("s.json", "{}").string();
  check_refused({"run", scene, "--json", scene}, {"--json", "the same file as SCENE"});
  check_refused({"scenes", "cubes-on-plane", "--write", "/dev/full"}, {"No space left"}, 1);
  CHECK(read_file(old) == "old");
  CHECK(names_in(folder) == std::vector<std::string>{"old.jsonl", "s.json"});
}

TEST_CASE("program: a full disk behind stdout is a failure of one line") {
  const TemporaryFolder folder;
  const std::string records = folder.write("r.jsonl", record("a", R"({"kind":"sphere","radius":1})")).string();
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{"scenes"}, {"--help"}, {"query", records}, small_run}) {
    const Ended ended = tandem_program(arguments, {.out = "/dev/full"});
    CAPTURE(arguments);
    CHECK(ended.status == 1);
    CHECK(ended.err == "tandem: stdout: No space left on device\n");
  }
}

TEST_CASE("program: a closed stdout brings no crash and no results in a wrong file") {
  const TemporaryFolder folder;
  const std::string json = (folder / "steps.jsonl").string();
  const Ended ended = tandem_program(small_run_with({"--json", json}), {.close_out = true});
  CHECK(ended.status == 1);
  CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
  CHECK(json_lines(read_file(json)).size() == 3);
}

TEST_CASE("program: query answers in order, bad records with their error, and ends with status 1") {
  const TemporaryFolder folder;
  const std::string sphere = R"({"kind":"sphere","radius":1})";
  const std::string text = record("good", sphere) + record("nan", sphere, R"({"t":[NaN,0,0]})") + "\n" +
                           record("mirror", sphere, R"({"t":[0,0,0],"R":[[1,0,0],[0,1,0],[0,0,-1]]})") +
                           record("negative", R"({"kind":"box","size":[1,-1,1]})") +
                           record("index", R"({"kind":"mesh","vertices":[[0,0,0]],"triangles":[[0,0,1]]})") +
                           record("empty", R"({"kind":"convex","vertices":[]})") +
                           record("file", R"({"kind":"mesh","file":"none.obj"})") + record("last", sphere);
  for (const bool from_stdin : {false, true}) {
    const std::string file = folder.write("r.jsonl", text).string();
    const Ended ended = from_stdin ? tandem_program({"query", "-"}, {.in = file}) : tandem_program({"query", file});
    CHECK(ended.status == 1);
    CHECK(ended.err.empty());
    const std::vector<Json> answers = json_lines(ended.out);
    REQUIRE(answers.size() == 8);
    CHECK(answers[0]["collide"] == true);
    CHECK(answers[7]["id"] == "last");
    CHECK(answers[7]["collide"] == true);
    const std::string expected[] = {"/poseA/t/0",
                                    "/poseA",
                                    "/shapeA/size/1: -1, allowed: a number > 0",
                                    "/shapeA/triangles/0/2: 1, allowed: ",
                                    "/shapeA/vertices: [], allowed: ",
                                    "/shapeA/file: "};
    const int lines[] = {2, 4, 5, 6, 7, 8};
    for (std::size_t i = 0; i < 6; ++i) {
      CHECK(answers[i + 1]["status"] == "error");
      CHECK(answers[i + 1]["line"] == lines[i]);
      CHECK_THAT(answers[i + 1]["error"].get<std::string>(), Catch::Contains(expected[i]));
    }
  }
  const std::string good = folder.write("good.jsonl", record("a", sphere)).string();
  CHECK(tandem_program({"query", good}).status == 0);
  CHECK(json_lines(tandem_program({"query", good, "--time"}).out)[0]["ns"].get<double>() > 0);
}

TEST_CASE("program: a record nested too deep is answered with its error, and the next one is read") {
  const TemporaryFolder folder;
  const std::string deep = std::string(50'000, '[') + std::string(50'000, ']');
  const std::string ball = R"({"kind":"sphere","radius":1})";
  const auto file = folder.write("records.jsonl", R"({"id":)" + deep + "}\n" + R"({"id":1,"shapeA":)" + deep + "}\n" +
                                                      R"({"id":2,")" + std::string(400'000, 'k') + R"(":)" + deep +
                                                      "}\n" + record("last", ball));
  const Ended ended = tandem_program({"query", file.string()});
  CHECK(ended.status == 1);
  CHECK(ended.err.empty());
  const std::vector<Json> answers = json_lines(ended.out);
  REQUIRE(answers.size() == 4);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(answers[i]["status"] == "error");
    CHECK(answers[i]["line"] == i + 1);
    CHECK(answers[i]["error"].get<std::string>().size() < 300);
  }
  CHECK(answers[3]["collide"] == true);
}

TEST_CASE("program: input that never ends is refused") {
  check_refused({"run", "/dev/zero"},
                {"/dev/zero: a pipe, device or growing file that goes on, allowed: at most 512 MiB"});
  // The first line never ends: one answer, and no next line.
  const Ended zeros = tandem_program({"query", "/dev/zero"});
  CHECK(zeros.status == 1);
  const std::vector<Json> answers = json_lines(zeros.out);
  REQUIRE(answers.size() == 1);
  CHECK(answers[0]["error"] == "a longer line, allowed: at most 512 MiB");
  // Endless lines, none of which is a record.
  const TemporaryFolder folder;
  const std::string err = (folder / "err").string();
  for (const std::string line : {"y", "''"}) {
    const int status = std::system(("yes " + line + " | " + program() + " query - >/dev/null 2>" + err).c_str());
    CHECK(WEXITSTATUS(status) == 2);
    CHECK_THAT(read_file(err), Catch::StartsWith("tandem: stdin: line 100001: ") && Catch::Contains("one in 100000"));
  }
}

TEST_CASE("program: pipes that end are read as files are") {
  const TemporaryFolder folder;
  const std::string ball = R"({"kind":"sphere","radius":1})";
  const auto scene = folder.write("s.json", R"({"shapes":{"b":)" + ball + R"(},"bodies":[{"shape":"b"}]})").string();
  const auto records = folder.write("r.jsonl", record("a", ball)).string();
  const std::string out = (folder / "out").string();
  const auto shell = [&](const std::string& command) { return std::system((command + " >" + out + " 2>&1").c_str()); };
  CHECK(shell("cat " + scene + " | " + program() + " run /dev/stdin --steps 1") == 0);
  CHECK_THAT(read_file(out), Catch::Contains("1 bodies"));
  for (const std::string file : {"-", "/dev/stdin"}) {
    CHECK(shell("cat " + records + " | " + program() + " query " + file) == 0);
    CHECK(json_lines(read_file(out)).at(0)["collide"] == true);
  }
  CHECK(WEXITSTATUS(shell(program() + " query - <" + folder.path().string())) == 2);
  CHECK_THAT(read_file(out), Catch::Contains("stdin: a directory"));
  CHECK(shell(program() + " query /dev/null") == 0);
  CHECK(read_file(out).empty());
}

TEST_CASE("program: a refusal is under 300 characters, however long what it names") {
  const std::string long_name(400'000 / 4, 'x');  // the longest argument is 128 KiB
  for (const auto& arguments : std::vector<std::vector<std::string>>{{"run", long_name},
                                                                     {"query", long_name},
                                                                     {long_name},
                                                                     {"run", "--" + long_name},
                                                                     {"run", "cubes-on-plane", "--steps", long_name},
                                                                     {"run", "cubes-on-plane", "--json", long_name},
                                                                     {"query", "-", "--solver", long_name},
                                                                     {"run", "no-such-scene"}}) {
    const Ended ended = tandem_program(arguments);
    CAPTURE(arguments[0].substr(0, 20), ended.err.substr(0, 400));
    CHECK(ended.status == 2);
    CHECK(ended.err.size() < 300);
    CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
  }
}

namespace {

// A cube of edge 1 about (x, y, 0) as an OBJ file; not closed: without its last face.
std::string cube(double x, double y, bool closed = true) {
  std::string out;
  for (const double cx : {-0.5, 0.5})
    for (const double cy : {-0.5, 0.5})
      for (const double cz : {-0.5, 0.5})
        out += "v " + std::to_string(x + cx) + ' ' + std::to_string(y + cy) + ' ' + std::to_string(cz) + '\n';
  out += "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\n";
  return closed ? out + "f 2 6 8 4\n" : out;
}

}  // namespace

TEST_CASE("program: clash tells parts that intersect, lie inside or are too near") {
  const TemporaryFolder folder;
  folder.write("a.obj", cube(0, 0));
  folder.write("b.obj", cube(0.9, 0.25));
  folder.write("c.obj", cube(2, 0));
  folder.write("far.obj", cube(9, 9));
  folder.write("notes.txt", "not a mesh");
  folder.write("small.obj", "v 9 9 0\nv 9.1 9 0\nv 9 9.1 0\nv 9 9 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const std::string in = folder.path().string(), page = (folder / "page.html").string();
  const Ended told = tandem_program({"clash", in, "--clearance", "0.2", "--json", "--report", page});
  CHECK(told.err.empty());
  REQUIRE(told.status == 0);
  const auto lines = json_lines(told.out);
  REQUIRE(lines.size() == 3);
  CHECK(lines[0]["a"].get<std::string>().ends_with("far.obj"));
  CHECK(lines[0]["b"].get<std::string>().ends_with("small.obj"));
  CHECK(lines[0]["intersects"] == true);
  CHECK(lines[0]["triangle_pairs"] == 0);
  CHECK(lines[1]["distance"].get<double>() == Approx(-0.1));
  CHECK(lines[1]["triangle_pairs"].get<int>() > 0);
  CHECK(lines[2]["intersects"] == false);
  CHECK(lines[2]["distance"].get<double>() == Approx(0.1));
  CHECK(read_file(page).find("small.obj") != std::string::npos);
  for (const char* threads : {"1", "3"})
    CHECK(tandem_program({"clash", in, "--clearance", "0.2", "--json", "--threads", threads}).out == told.out);

  const Ended table = tandem_program({"clash", in + "/a.obj", in + "/b.obj"});
  CHECK(table.out.find("1 of 1 pairs of 2 parts intersect") != std::string::npos);
  CHECK(table.out.find("a.obj  b.obj  0.1 deep") != std::string::npos);

  const std::string sides = "f -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n";
  folder.write("feet.obj", "v 0.4 0 0\nv 0.6 0 0\nv 0.4 0.1 0\nv 0.4 0 0.1\n" + sides +
                               "v -0.6 0 0\nv -0.4 0 0\nv -0.6 0.1 0\nv -0.6 0 0.1\n" + sides);
  const auto feet = json_lines(tandem_program({"clash", in + "/a.obj", in + "/feet.obj", "--json"}).out).at(0);
  CHECK(feet["zone_count"] == 2);
  CHECK(feet["zones"].at(0)["triangle_pairs"].get<int>() + feet["zones"].at(1)["triangle_pairs"].get<int>() ==
        feet["triangle_pairs"].get<int>());
  for (const auto& zone : feet["zones"]) CHECK(std::abs(zone["place"].at(0).get<double>()) == Approx(0.5).margin(0.1));

  folder.write("open.obj", cube(0, 5, false));
  const Ended open = tandem_program({"clash", in + "/a.obj", in + "/open.obj"});
  CHECK(open.out.find("open.obj: a surface, whose inside does not count") != std::string::npos);
}

TEST_CASE("program: clash goes on where it was cut off, and leaves files alone that are not its own") {
  const TemporaryFolder folder;
  for (int i = 0; i < 6; ++i) folder.write("part" + std::to_string(i) + ".obj", cube(0.7 * i, 0.1 * i));
  const std::string in = folder.path().string(), kept = (folder / "kept").string();
  const Ended whole = tandem_program({"clash", in, "--json", "--resume", kept});
  REQUIRE(whole.status == 0);
  REQUIRE(json_lines(whole.out).size() == 5);
  const std::string all = read_file(kept);
  REQUIRE(json_lines(all).size() == 6);
  for (std::size_t length = 0; length < all.size(); length += 97) {
    folder.write("kept", all.substr(0, length));
    REQUIRE(tandem_program({"clash", in, "--json", "--resume", kept}).out == whole.out);
    REQUIRE(json_lines(read_file(kept)).size() == 6);
  }
  // Answers in the file are not computed again.
  std::string changed = all;
  const std::size_t at = changed.find("\"distance\":-") + 12;
  changed.replace(at, 2, "7.");  // of 0.3, or of 0.29999999999999982: which pair comes first differs
  folder.write("kept", changed);
  CHECK(tandem_program({"clash", in, "--json", "--resume", kept}).out.find("\"distance\":-7.") != std::string::npos);

  const std::string mesh = cube(0, 0);
  for (const std::string& other : {mesh, std::string("one line without an end"), all}) {
    folder.write("other", other);
    const Ended refused = tandem_program({"clash", in, "--clearance", "1", "--resume", (folder / "other").string()});
    CHECK(refused.status == 2);
    CHECK(refused.err.find("--resume") != std::string::npos);
    CHECK(read_file(folder / "other") == other);
  }
}

TEST_CASE("program: clash refuses answers that it cannot have written, by their line and place") {
  const TemporaryFolder folder;
  folder.write("a.obj", cube(0, 0));
  folder.write("b.obj", cube(0.5, 0.1));
  const std::string a = (folder / "a.obj").string(), b = (folder / "b.obj").string(), kept = (folder / "kept").string();
  REQUIRE(tandem_program({"clash", a, b, "--resume", kept}).status == 0);
  const std::string all = read_file(kept);
  const std::size_t begin = all.find('\n') + 1;
  const auto refusal = [&](const char* pointer, const Json& value) {
    Json entry = parse_json(all.substr(begin));
    entry[Json::json_pointer(pointer)] = value;
    folder.write("kept", all.substr(0, begin) + entry.dump() + '\n');
    const Ended refused = tandem_program({"clash", a, b, "--resume", kept});
    CAPTURE(pointer, value.dump(), refused.err);
    CHECK(refused.status == 2);
    CHECK(refused.out.empty());
    CHECK(refused.err.find(": line 2: " + std::string(pointer)) != std::string::npos);
    CHECK(refused.err.find(", allowed: ") != std::string::npos);
    CHECK(refused.err.size() < 300);
  };
  for (const char* pair : {"[]", "[0]", "[0,1,1]", "[1,0]", "[0,0]", "{}", "1"}) refusal("/pair", parse_json(pair));
  for (const char* bounds : {"[]", "[[0,0,0]]", "[[0,0,0],[0,0,0],[0,0,0]]", "0"})
    refusal("/zones/0/bounds", parse_json(bounds));
  for (const char* number : {"\"x\"", "-1", "1.5", "null", "{}", "1e300"})
    for (const char* pointer : {"/triangle_pairs", "/zone_count", "/zones/0/triangle_pairs"})
      refusal(pointer, parse_json(number));
  refusal("/error_bound", -1);
}

TEST_CASE("program: clash waits for no pipe, and says what a name leads to") {
  const TemporaryFolder folder;
  folder.write("a.obj", cube(0, 0));
  folder.write("b.obj", cube(0.5, 0.1));
  REQUIRE(::mkfifo((folder / "pipe.obj").c_str(), 0600) == 0);
  std::filesystem::create_directory(folder / "other");
  std::filesystem::create_symlink("loop.obj", folder / "other/loop.obj");
  const std::string a = (folder / "a.obj").string(), b = (folder / "b.obj").string();
  const auto refused = [&](const std::vector<std::string>& words, const std::string& says) {
    const Ended ended = tandem_program(words);
    CAPTURE(ended.err);
    CHECK(ended.status == 2);
    CHECK(ended.err.find(says) != std::string::npos);
  };
  const std::string pipe = (folder / "pipe.obj").string(), loop = (folder / "other/loop.obj").string();
  refused({"clash", folder.path().string()}, "a regular file");
  refused({"clash", a, b, "--resume", pipe}, "a folder, pipe or device, allowed: a regular file");
  refused({"clash", a, b, "--resume", "/dev/null"}, "a folder, pipe or device, allowed: a regular file");
  refused({"clash", a, loop}, "no file or folder '" + loop + "': ");
}

TEST_CASE("program: clash refuses what it cannot read, before the work") {
  const TemporaryFolder folder;
  folder.write("a.obj", cube(0, 0));
  folder.write("cut.stl", "solid\nfacet normal 0 0 1\n");
  const std::string in = folder.path().string();
  const std::vector<std::pair<std::vector<std::string>, std::string>> bad = {
      {{in + "/a.obj"}, "at least two"},
      {{in + "/a.obj", in + "/a.obj"}, "twice"},
      {{in + "/a.obj", in + "/none.stl"}, "none.stl"},
      {{in + "/a.obj", in + "/none"}, "no file or folder '" + in + "/none'"},
      {{in + "/a.obj", in + "/cut.stl"}, "cut.stl"},
      {{in + "/a.obj", in + "/cut.stl", "--clearance", "-1"}, "--clearance"},
      {{in, "--report", in + "/no/page.html"}, "--report"},
      {{in, "--resume", in + "/a.obj"}, "FILES"},
  };
  for (const auto& [arguments, message] : bad) {
    std::vector<std::string> words = {"clash"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    const Ended refused = tandem_program(words);
    CHECK(refused.status == 2);
    CHECK(refused.out.empty());
    INFO(refused.err);
    CHECK(refused.err.find(message) != std::string::npos);
  }
}

TEST_CASE("program: a timeline is compressed if its name says so, and has a bound that is told") {
  const TemporaryFolder folder;
  const std::string plain = (folder / "t.json").string(), packed = (folder / "t.json.gz").string();
  for (const std::string& file : {plain, packed})
    REQUIRE(tandem_program({"run", "cubes-on-plane", "--bodies", "50", "--steps", "3", "--trace", file}).status == 0);
  const std::string bytes = read_file(packed);
  CHECK(is_gzipped(bytes));
  const std::string text = gunzipped(bytes, 1u << 24);
  CHECK(parse_json(text).contains("traceEvents"));
  CHECK_THROWS_WITH(gunzipped(bytes.substr(0, bytes.size() / 2), 1u << 24), Catch::Contains("cut off"));
  CHECK_THROWS_WITH(gunzipped(bytes, 10), Catch::Contains("more inside"));
  CHECK(gunzipped(gzipped(std::string(5'000'000, 'x')), 5'000'000) == std::string(5'000'000, 'x'));
  CHECK(gunzipped(gzipped(""), 0).empty());
}

TEST_CASE("program: inspect tells what is wrong with mesh files, with places") {
  const TemporaryFolder folder;
  folder.write("clean.obj", cube(0, 0));
  folder.write("open.obj", cube(0, 5, false));
  const std::string clean = (folder / "clean.obj").string(), open = (folder / "open.obj").string();
  const Ended told = tandem_program({"inspect", clean, open, "--json", "--most", "2"});
  CHECK(told.err.empty());
  REQUIRE(told.status == 0);
  const auto lines = json_lines(told.out);
  REQUIRE(lines.size() == 2);
  CHECK(lines[0]["clean_solid"] == true);
  CHECK(lines[1]["closed"] == false);
  CHECK(lines[1]["faulty_edges"]["count"].get<int>() >= 3);
  REQUIRE(lines[1]["faulty_edges"]["first"].size() == 2);
  CHECK(lines[1]["faulty_edges"]["first"][0]["fault"] == "open");
  const Ended words = tandem_program({"inspect", clean, open});
  CHECK(words.out.find("a clean solid") != std::string::npos);
  CHECK(words.out.find("open edge from vertex") != std::string::npos);
  CHECK(tandem_program({"inspect"}).status == 2);
  folder.write("far.obj", "v 0 0 0\nv 1e31 0 0\nf 1 2 1\n");
  const Ended far = tandem_program({"inspect", clean, (folder / "far.obj").string()});
  CHECK(far.status == 2);
  CHECK(far.err.find("far.obj: mesh: vertices[1] is (1e31, 0, 0); it must be finite and at most 1e30 in size") !=
        std::string::npos);
  CHECK(tandem_program({"inspect", (folder / "none.obj").string()}).status != 0);
}
