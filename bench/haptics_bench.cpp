// The loop of a haptic device, a thousand queries a second: a tool of 10,000 triangles glides over a scene of 500,000,
// approaches, touches and penetrates it. The result is the slowest of a thousand queries, not the mean.
#include <fcl/narrowphase/distance.h>
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <numbers>

#include "ball_triangles.h"
#include "benches.h"
#include "clocks.h"
#include "fcl_model.h"
#include "fcl_shape.h"
#include "tandem/engine/scene_queries.h"
#include "tandem/narrowphase/prepare.h"
#include "tandem/narrowphase/shape_makers.h"

namespace tandem::bench {
namespace {

constexpr double reach = 0.01;  // metres, the limit of the distances asked for

/// The height of the ground in metres, over a square of one metre.
double ground(double x, double y) {
  return 0.03 * std::sin(9 * x) * std::cos(7 * y) + 0.002 * std::sin(80 * x + 50 * y);
}

constexpr std::size_t cells = 352;  // a quarter of a million triangles at the top, as many at the bottom

Shape scene_shape() {
  std::vector<double> heights;
  for (std::size_t j = 0; j <= cells; ++j)
    for (std::size_t i = 0; i <= cells; ++i)
      heights.push_back(ground(static_cast<double>(i) / cells - 0.5, static_cast<double>(j) / cells - 0.5));
  return height_field(heights, cells + 1, cells + 1, 1.0 / cells, -0.1);
}

/// A ball of 3 cm with grooves, 2 * 100 * 50 triangles.
Mesh tool_mesh() {
  constexpr int turns = 100, rings = 50;
  Mesh mesh;
  mesh.solid = true;
  mesh.vertices.emplace_back(0, 0, -0.03);
  for (int j = 1; j < rings; ++j)
    for (int i = 0; i < turns; ++i) {
      const double u = 2 * std::numbers::pi * i / turns, v = std::numbers::pi * j / rings;
      const double r = 0.03 * (1 + 0.02 * std::sin(12 * u) * std::sin(v));
      mesh.vertices.emplace_back(r * std::sin(v) * std::cos(u), r * std::sin(v) * std::sin(u), -r * std::cos(v));
    }
  mesh.vertices.emplace_back(0, 0, 0.03);
  add_ball_triangles(mesh, turns, rings);
  return mesh;
}

/// The pose of the tool at this time: about 20 cm a second, from 1 mm in the ground to 1 cm above it.
Pose tool_pose(int ms) {
  const double t = 0.001 * ms, x = 0.4 * std::sin(0.5 * t), y = 0.4 * std::sin(0.37 * t + 1);
  const double gap = 0.0045 + 0.0055 * std::sin(2.3 * t);
  const Quat turn = Quat(Eigen::AngleAxisd(0.8 * t, Vec3(1, 2, 3).normalized()));
  return {turn.toRotationMatrix(), {x, y, ground(x, y) + 0.031 + gap}};
}

std::size_t fcl_contacts(const FclModel& tool, const Pose& pose, const FclModel& ground, std::size_t most,
                         bool with_contacts) {
  ::fcl::CollisionResultd result;
  ::fcl::collide(&tool, fcl_pose(pose), &ground, ::fcl::Transform3d::Identity(),
                 ::fcl::CollisionRequestd(most, with_contacts), result);
  return result.numContacts();
}

double fcl_distance(const FclModel& tool, const Pose& pose, const FclModel& ground) {
  ::fcl::DistanceResultd result;
  return ::fcl::distance(&tool, fcl_pose(pose), &ground, ::fcl::Transform3d::Identity(), ::fcl::DistanceRequestd(true),
                         result);
}

struct Query {
  std::string workload, contestant;
  int every;  // milliseconds between two
  std::function<double(const Pose&)> run;
  Samples time{};
  std::uint64_t hash = 0;
  std::size_t answered = 0;
};

void run(Query& query, const Pose& pose) {
  const double begin = cpu_ns();
  const double answer = query.run(pose);
  const double end = cpu_ns();
  query.time.add(end - begin);
  query.hash = std::rotl(query.hash, 5) ^ std::bit_cast<std::uint64_t>(answer + 0.0);
  query.answered += answer != 0;
}

/// A histogram of times in factors of two, the fraction of queries in each.
nlohmann::json histogram(const Samples& time) {
  nlohmann::json bins = nlohmann::json::array();
  for (double upper = 1000; upper < 1e9; upper *= 2) {
    std::size_t in_bin = 0;
    for (std::size_t i = 0; i < time.size(); ++i) in_bin += time[i] < upper && (time[i] >= upper / 2 || upper == 1000);
    if (in_bin > 0) bins.push_back({{"below_us", upper / 1000}, {"queries", in_bin}});
  }
  return bins;
}

std::vector<Row> report(const std::vector<Query>& all, std::size_t triangles) {
  fmt::print("{:36}  {:8}{:>8}{:>9}{:>9}{:>9}{:>9}  hash\n", "", "", "median", "p99", "p99.9", "max", "touching");
  std::vector<Row> rows;
  for (const Query& query : all) {
    const Samples& t = query.time;
    fmt::print("{:36}  {:8}{:8.1f}{:9.1f}{:9.1f}{:9.1f}{:8.0f}%  {}\n", query.workload, query.contestant,
               t.median() / 1000, t.quantile(0.99) / 1000, t.quantile(0.999) / 1000, t.quantile(1) / 1000,
               100.0 * static_cast<double>(query.answered) / static_cast<double>(t.size()), hex(query.hash));
    Row row;
    row.bench = "haptics";
    row.workload = query.workload;
    row.contestant = query.contestant;
    row.n = triangles;
    row.time = t;
    row.hash = query.hash;
    row.more = {{"p99_ns", t.quantile(0.99)},
                {"p99_9_ns", t.quantile(0.999)},
                {"max_ns", t.quantile(1)},
                {"histogram", histogram(t)}};
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

std::vector<Row> haptics_bench(const Settings& settings) {
  const Shape ground_shape = scene_shape(), tool(tool_mesh());
  prepare(tool);  // SceneQueries prepares the scene's shapes
  Scene scene;
  BodyOptions body;
  body.shape = scene.add_shape(ground_shape);
  body.is_static = true;
  scene.add_body(body);
  NarrowPhaseOptions options;
  options.mesh_bounds = false;  // contacts for a force need no proven bound on the depth
  const SceneQueries queries(scene, options);
  const auto fcl_ground = fcl_model(ground_shape.vertices(), ground_shape.triangles());
  const auto fcl_tool = fcl_model(tool.vertices(), tool.triangles());
  std::vector<ContactHit> hits;
  std::vector<Contact> contacts;
  std::vector<Query> all{
      {"yes/no", "tandem", 1, [&](const Pose& pose) { return queries.collides(tool, pose) ? 1.0 : 0.0; }},
      {"yes/no", "FCL", 10,
       [&](const Pose& pose) { return fcl_contacts(*fcl_tool, pose, *fcl_ground, 1, false) > 0 ? 1.0 : 0.0; }},
      {"nearest within 1 cm, of those apart", "tandem", 1,
       [&](const Pose& pose) {
         if (queries.collides(tool, pose)) return 0.0;
         const auto hit = queries.nearest(tool, pose, reach);
         return hit ? hit->answer.signed_distance : reach;
       }},
      {"nearest within 1 cm, of those apart", "FCL", 20,
       [&](const Pose& pose) { return std::clamp(fcl_distance(*fcl_tool, pose, *fcl_ground), 0.0, reach); }},
      {"contacts", "tandem", 1,
       [&](const Pose& pose) {
         hits.clear();
         contacts.clear();
         queries.contacts(tool, pose, 0, hits, contacts);
         double deepest = 0;
         for (const Contact& c : contacts) deepest = std::max(deepest, c.depth);
         return deepest;
       }},
      {"contacts", "FCL", 50,
       [&](const Pose& pose) { return static_cast<double>(fcl_contacts(*fcl_tool, pose, *fcl_ground, 1000, true)); }}};
  const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 1000 : 20'000;
  for (int ms = 0; ms < steps; ++ms)
    for (Query& query : all)
      if (ms % query.every == 0) run(query, tool_pose(ms));

  fmt::print("A tool of {} triangles against {}, {} steps of 1 ms; microseconds of a query on one thread\n\n",
             tool.triangles().size(), ground_shape.triangles().size(), steps);
  return report(all, tool.triangles().size() + ground_shape.triangles().size());
}

}  // namespace tandem::bench
