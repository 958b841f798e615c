// The bench of whole steps.
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "../engine/temporary_folder.h"
#include "catch.h"

using namespace tandem;

namespace {

int run(const std::string& program, const std::string& arguments, const std::filesystem::path& out) {
  const int status = std::system((program + " " + arguments + " > " + out.string() + " 2>&1").c_str());
  return WEXITSTATUS(status);
}

nlohmann::json rows_of(const std::filesystem::path& file) {
  nlohmann::json result;
  std::ifstream(file) >> result;
  return result.at("rows");
}

}  // namespace

TEST_CASE("peers bench: every scene, one answer of ours on one thread and two, and no pair that others miss") {
  const TemporaryFolder folder;
  const auto json = folder / "peers.json";
  REQUIRE(run(TANDEM_BENCH_PATH, "peers --quick --bodies 40 --steps 90 --json " + json.string(), folder / "out.txt") ==
          0);
  std::map<std::string, std::vector<nlohmann::json>> scenes;
  for (const auto& row : rows_of(json)) scenes[row.at("workload")].push_back(row);
  CHECK(scenes.size() == 7);
  for (const auto& [scene, rows] : scenes) {
    CAPTURE(scene);
    REQUIRE(rows.size() >= 5);
    CHECK(rows[0].at("contestant") == "tandem");
    CHECK(rows[1].at("contestant") == "tandem");
    CHECK(rows[1].at("threads") == 2);
    CHECK(rows[0].at("hash") == rows[1].at("hash"));
    CHECK(rows[0].at("pairs") > 100);
    CHECK(rows[0].at("contacts") >= rows[0].at("pairs"));
    // Kept contacts: the same answer.
    CHECK(rows[2].at("contestant") == "tandem, kept 1e-3");
    CHECK(rows[2].at("hash") == rows[3].at("hash"));
    // FCL's verdicts are exact except for contact to rounding.
    const double pairs = rows[0].at("pairs");
    CHECK(rows[4].at("contestant").get<std::string>().starts_with("FCL"));
    CHECK(rows[4].at("pairs_extra").get<double>() <= 0.002 * pairs);
    CHECK(rows[4].at("pairs_missed").get<double>() <= 0.002 * pairs);
  }
}

TEST_CASE("peers bench: poses from a record; a scene that is neither is refused") {
  const TemporaryFolder folder;
  const auto record = folder / "drop.record", json = folder / "peers.json";
  REQUIRE(run(TANDEM_PROGRAM_PATH, "run spheres-on-plane --bodies 30 --steps 40 --record " + record.string(),
              folder / "out.txt") == 0);
  REQUIRE(run(TANDEM_BENCH_PATH, "peers --scene " + record.string() + " --json " + json.string(), folder / "out.txt") ==
          0);
  const auto rows = rows_of(json);
  CHECK(rows[0].at("workload") == "drop");
  CHECK(rows[0].at("pairs") > 30);
  CHECK(run(TANDEM_BENCH_PATH, "peers --scene nothing", folder / "out.txt") == 2);
}

TEST_CASE("grains bench: pairs and depths are the cell list's, and memory is told") {
  const TemporaryFolder folder;
  const auto json = folder / "grains.json";
  REQUIRE(run(TANDEM_BENCH_PATH, "grains --sizes 300 --steps 60 --repeat 1 --json " + json.string(),
              folder / "out.txt") == 0);
  const auto rows = rows_of(json);
  REQUIRE(rows.size() >= 4);
  CHECK(rows[2].at("contestant") == "cells, depths");
  CHECK(rows[3].at("contestant") == "cells, whole list");
  CHECK(rows[0].at("hash") == rows[3].at("hash"));
  CHECK(rows[0].at("hash") == rows[2].at("hash"));
  CHECK(rows[1].at("hash") == rows[2].at("hash"));
  CHECK(rows[0].at("pairs") > 1000);
  CHECK(rows[0].at("scene_bytes_a_body") > 100);
  CHECK(rows[0].at("pipeline_bytes_a_body") > 50);
}

TEST_CASE("steps bench: of convex bodies no kept answer is beyond its bound, and no verdict wrong") {
  const TemporaryFolder folder;
  const auto json = folder / "steps.json";
  REQUIRE(run(TANDEM_BENCH_PATH,
              "steps --bodies 40 --steps 120 --json " + json.string() +
                  " --scene cubes-on-plane,mixed-grains,tori-and-cubes",
              folder / "out.txt") == 0);
  std::size_t kept = 0;
  for (const auto& row : rows_of(json)) {
    CAPTURE(row.at("workload"), row.at("contestant"));
    CHECK(row.at("beyond_bound") == 0);
    CHECK(row.at("wrong") == 0);
    CHECK(row.at("distance").at("max") <= row.at("told").at("max"));
    kept += row.at("kept_answers").get<std::size_t>();
    if (row.at("tolerance") == 0) CHECK(row.at("kept_answers") == 0);
  }
  CHECK(kept > 500);
}
