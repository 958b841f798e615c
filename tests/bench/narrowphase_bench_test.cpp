// The bench of the narrow phase.
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "../engine/temporary_folder.h"
#include "accuracy.h"
#include "catch.h"
#include "text_of.h"
#include "trial.h"

using namespace tandem;
using namespace tandem::bench;

namespace {

/// Unit spheres on the x axis, `gaps` apart.
Workload spheres(const std::vector<double>& gaps) {
  Workload work{"sphere-sphere", "near", {}, {}, 0};
  for (const double gap : gaps) {
    work.pairs.push_back({Shape(Sphere{1}), {}, Shape(Sphere{1}), Pose::at(2 + gap, 0, 0)});
    work.truths.push_back({.signed_distance = gap, .error = 0, .normal = Vec3::UnitX(), .normal_unique = true});
  }
  return work;
}

Found measured(double distance, const Vec3& normal = Vec3::UnitX()) {
  return {.collide = distance <= 0, .measured = true, .signed_distance = distance, .normal = normal};
}

int run(const std::string& arguments, const std::filesystem::path& out) {
  const std::string command = TANDEM_BENCH_PATH " " + arguments + " > " + out.string() + " 2>&1";
  return std::system(command.c_str());
}

}  // namespace

TEST_CASE("narrowphase bench: right answers have no error") {
  const Workload work = spheres({0.5, -0.5});
  const Accuracy a = judge(work, Request::distance, std::vector{measured(0.5), measured(-0.5)});
  CHECK(a.right());
  CHECK(a.error_max == 0);
  CHECK(a.normals == 0);
}

TEST_CASE("narrowphase bench: an error is relative to the size and beyond the truth's own") {
  Workload work = spheres({0.5});
  const double size = work.pairs[0].a.size();
  CHECK(judge(work, Request::distance, std::vector{measured(0.6)}).error_max == Approx(0.1 / size));
  work.truths[0].error = 0.04;
  CHECK(judge(work, Request::distance, std::vector{measured(0.6)}).error_max == Approx(0.06 / size));
}

TEST_CASE("narrowphase bench: wrong verdicts count unless the pair touches to 1e-15 of its size") {
  const Workload work = spheres({1e-6, 1e-16});
  const Found touches{.collide = true};
  const Accuracy a = judge(work, Request::collide, std::vector{touches, touches});
  CHECK(a.wrong == 1);
  CHECK(a.worst == 0);
  CHECK(a.error_max == Approx(1e-6 / work.pairs[0].a.size()));
  CHECK_FALSE(a.right());
}

TEST_CASE("narrowphase bench: failures, NaN and reversed normals are seen") {
  const Workload work = spheres({0.5, 0.5, 0.5});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector found{measured(0.5, -Vec3::UnitX()), measured(nan), Found{.failed = true}};
  const Accuracy a = judge(work, Request::distance, found);
  CHECK(a.failed == 2);
  CHECK(a.normals == 1);
  CHECK(a.wrong == 0);
  CHECK_FALSE(a.right());
}

TEST_CASE("narrowphase bench: a missing distance is not a right answer, a missing contact of what misses is") {
  const Workload work = spheres({0.5});
  CHECK_FALSE(judge(work, Request::distance, std::vector{Found{}}).right());
  CHECK(judge(work, Request::contacts, std::vector{Found{}}).right());
}

TEST_CASE("narrowphase bench: queries that abort or never end are found") {
  const auto query = [](std::size_t i) {
    if (i == 1) std::abort();
    for (volatile bool forever = i == 3; forever;) {
    }
  };
  CHECK(deadly_queries(5, query) == std::vector<char>{0, 1, 0, 1, 0});
}

TEST_CASE("narrowphase bench: a pair at which a library aborts is left out") {
  const AbortTrap trap;
  const auto solver = each_pair([](std::size_t i) {
    if (i == 1) std::abort();
    return Found{.collide = true};
  });
  std::vector<Found> found(3);
  for (int pass = 0; pass < 2; ++pass) {
    solver->answer(found);
    CHECK(solver->left_out() == 1);
    CHECK(found[0].collide);
    CHECK(found[1].failed);
    CHECK(found[2].collide);
  }
}

TEST_CASE("narrowphase bench: rows hold times, errors and the standing among the others") {
  const TemporaryFolder folder;
  const auto json = folder / "rows.json", out = folder / "out";
  const int status =
      run("narrowphase --quick --poses 4 --repeat 2 --kind sphere-sphere,halfspace-box --json " + json.string(), out);
  INFO(text_of(out));
  REQUIRE(status == 0);
  CHECK_THAT(text_of(out), Catch::Contains("separated") && Catch::Contains("halfspace-box"));
  const nlohmann::json result = nlohmann::json::parse(text_of(json));
  CHECK(result.at("machine").contains("cpu"));
  std::set<std::string> workloads;
  bool compared = false;
  for (const auto& row : result.at("rows")) {
    CHECK(row.at("bench") == "narrowphase");
    for (const char* member :
         {"median_ns", "p10_ns", "p90_ns", "error_p50", "error_p99", "error_max", "wrong", "failed", "n", "threads"})
      CHECK(row.at(member).is_number());
    CHECK(row.at("hash").get<std::string>().size() == 16);
    if (row.at("contestant") != "tandem") continue;
    workloads.insert(row.at("workload"));
    CHECK(row.at("median_ns") > 0);
    compared = compared || row.contains("fastest_right_rival");
  }
  CHECK(workloads.size() == 2 * 6 * 3);
  CHECK(workloads.count("halfspace-box/hard/contacts") == 1);
  CHECK(compared);
}

TEST_CASE("narrowphase bench: an unknown kind is answered with those there are") {
  const TemporaryFolder folder;
  CHECK(run("narrowphase --kind box-bix", folder / "out") != 0);
  CHECK_THAT(text_of(folder / "out"), Catch::Contains("--kind") && Catch::Contains("box-bix") &&
                                          Catch::Contains("cone-cone") && Catch::Contains("torus-torus"));
}
