// A piece of cloth that folds over a ball and onto itself: time of setting new vertices, of the triangle pairs with the
// ball and within the cloth, beside FCL's three kinds of update.
#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "benches.h"
#include "clocks.h"
#include "fcl_model.h"
#include "meshes/mesh_pair.h"
#include "tandem/narrowphase/deformable_mesh.h"

namespace tandem::bench {
namespace {

// A point of the cloth, of side 2 metres: half of it is rolled up about a radius and comes down on the other half,
// wrinkled.
Vec3 folded(double x, double y, double t) {
  constexpr double radius = 0.1;
  const double angle = 1.25 * std::numbers::pi * t, arc = std::clamp(x / radius, 0.0, angle);
  const double rest = std::max(0.0, x - radius * angle);
  Vec3 p(std::min(x, 0.0) + radius * std::sin(arc) + rest * std::cos(angle), y,
         radius * (1 - std::cos(arc)) + rest * std::sin(angle));
  p.z() += 0.01 * std::sin(17 * x + 5 * t) * std::cos(13 * y - 3 * t);
  return p;
}

std::vector<Vec3> sheet_vertices(int n, double t) {
  std::vector<Vec3> vertices;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) vertices.push_back(folded(2.0 * i / n - 1, 2.0 * j / n - 1, t));
  return vertices;
}

Mesh sheet(int n) {
  Mesh mesh;
  mesh.vertices = sheet_vertices(n, 0);
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

// A ball of 2 turns (rings - 1) triangles, which penetrates the half that stays.
Mesh ball() {
  constexpr int turns = 140, rings = 70;
  Mesh mesh;
  const Vec3 centre(-0.4, 0, -0.3);
  const auto at = [&](int j, int i) { return static_cast<std::uint32_t>(j * turns + i % turns); };
  for (int j = 0; j <= rings; ++j)
    for (int i = 0; i < turns; ++i) {
      const double u = 2 * std::numbers::pi * i / turns, v = std::numbers::pi * j / rings;
      mesh.vertices.push_back(centre + 0.35 * Vec3(std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), -std::cos(v)));
    }
  for (int j = 0; j < rings; ++j)
    for (int i = 0; i < turns; ++i) {
      if (j > 0) mesh.triangles.push_back({at(j, i), at(j, i + 1), at(j + 1, i + 1)});
      if (j + 1 < rings) mesh.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j + 1, i)});
    }
  return mesh;
}

enum class FclUpdate { update, replace, rebuild };
void move_to(FclModel& model, const std::vector<Vec3>& vertices, FclUpdate how) {
  if (how == FclUpdate::update) {
    model.beginUpdateModel();
    model.updateSubModel(vertices);
    model.endUpdateModel(true, true);
  } else {
    model.beginReplaceModel();
    model.replaceSubModel(vertices);
    model.endReplaceModel(how == FclUpdate::replace, true);
  }
}

/// The work of one contestant in a step; returns the pairs found, if asked for pairs.
struct PairTask {
  std::string workload, contestant;
  int threads;
  std::function<TrianglePairs()> run;
  Samples time{};
  std::uint64_t hash = 0;
  std::size_t pairs = 0;
};

void run(PairTask& task) {
  const auto clock = task.threads == 1 ? cpu_ns : wall_ns;
  const double begin = clock();
  const TrianglePairs pairs = task.run();
  task.time.add(clock() - begin);
  task.hash = std::rotl(task.hash, 9) ^ hash_of(pairs);
  task.pairs += pairs.size();
}

/// True if it found other pairs than the first task with the same question, which is tandem after a refit.
bool differs(const PairTask& task, const std::vector<PairTask>& tasks) {
  const auto first =
      std::find_if(tasks.begin(), tasks.end(), [&](const PairTask& t) { return t.workload == task.workload; });
  return first->hash != task.hash;
}

/// All must have found the same, except FCL after its update, which now and then loses pairs that it finds after a
/// rebuild.
void require_agreement(const std::vector<PairTask>& tasks) {
  for (const PairTask& task : tasks)
    if (differs(task, tasks) && task.contestant != "FCL, update")
      throw std::runtime_error(fmt::format("{}: {} found other pairs than tandem", task.workload, task.contestant));
}

void print(const std::vector<PairTask>& tasks) {
  fmt::print("{:22}{:20}{:>8}{:>10}{:>10}{:>10}{:>12}  hash\n", "", "", "threads", "ms", "p10", "p90", "pairs");
  for (const PairTask& t : tasks)
    fmt::print("{:22}{:20}{:8}{:10.3f}{:10.3f}{:10.3f}{:12}  {}{}\n", t.workload, t.contestant, t.threads,
               t.time.median() / 1e6, t.time.quantile(0.1) / 1e6, t.time.quantile(0.9) / 1e6, t.pairs, hex(t.hash),
               differs(t, tasks) ? " differs" : "");
}

std::vector<Row> rows_of(const std::vector<PairTask>& tasks, std::size_t triangles) {
  std::vector<Row> rows;
  for (const PairTask& task : tasks) {
    Row& row = rows.emplace_back();
    row.bench = "cloth";
    row.workload = task.workload;
    row.contestant = task.contestant;
    row.threads = task.threads;
    row.n = triangles;
    row.time = task.time;
    row.hash = task.hash;
    row.more = {{"pairs", task.pairs}};
  }
  return rows;
}

}  // namespace

std::vector<Row> cloth_bench(const Settings& settings) {
  const std::size_t wanted = !settings.sizes.empty() ? settings.sizes[0] : settings.quick ? 5'000 : 100'000;
  const int n = std::max(2, static_cast<int>(std::lround(std::sqrt(static_cast<double>(wanted) / 2))));
  const int steps = settings.steps != 0 ? settings.steps : settings.quick ? 4 : 24;
  const Mesh input = sheet(n), obstacle = ball();
  const Shape ball_shape(obstacle);
  const auto ball_model = fcl_model(obstacle);
  DeformableMesh cloth(input), threaded(input);
  const auto updated = fcl_model(input), replaced = fcl_model(input), rebuilt = fcl_model(input);
  const PartRunner on_threads = [](std::size_t parts, const auto& part) {
    tbb::parallel_for(std::size_t{0}, parts, part);
  };
  std::vector<Vec3> vertices;
  std::optional<Shape> anew;
  std::size_t rebuilt_triangles = 0;
  const Pose home{};
  const TrianglePairs none;
  const std::string move = "new vertices", with_ball = "pairs with a ball", with_itself = "pairs with itself";
  std::vector<PairTask> tasks{
      {move, "tandem, refit", 1, [&] { return rebuilt_triangles += cloth.update(vertices).rebuilt_triangles, none; }},
      {move, "tandem, refit", 2, [&] { return threaded.update(vertices, on_threads), none; }},
      {move, "tandem, anew", 1,
       [&] {
         return anew.emplace(Mesh{vertices, input.triangles, false}), none;
       }},
      {move, "FCL, update", 1, [&] { return move_to(*updated, vertices, FclUpdate::update), none; }},
      {move, "FCL, replace", 1, [&] { return move_to(*replaced, vertices, FclUpdate::replace), none; }},
      {move, "FCL, rebuild", 1, [&] { return move_to(*rebuilt, vertices, FclUpdate::rebuild), none; }},
      {with_ball, "tandem, refit", 1, [&] { return mesh_triangle_pairs(cloth.shape(), home, ball_shape, home, {}); }},
      {with_ball, "tandem, anew", 1, [&] { return mesh_triangle_pairs(*anew, home, ball_shape, home, {}); }},
      {with_ball, "FCL, update", 1, [&] { return fcl_pairs(*updated, *ball_model, nullptr); }},
      {with_ball, "FCL, replace", 1, [&] { return fcl_pairs(*replaced, *ball_model, nullptr); }},
      {with_ball, "FCL, rebuild", 1, [&] { return fcl_pairs(*rebuilt, *ball_model, nullptr); }},
      {with_itself, "tandem, refit", 1, [&] { return cloth.self_intersections(); }},
      {with_itself, "tandem, refit", 2, [&] { return threaded.self_intersections(on_threads); }},
      {with_itself, "FCL, replace", 1, [&] { return fcl_pairs(*replaced, *replaced, &input); }}};
  for (int step = 1; step <= steps; ++step) {
    vertices = sheet_vertices(n, static_cast<double>(step) / steps);
    for (PairTask& task : tasks) run(task);
  }
  fmt::print("A folding sheet of {} triangles, a ball of {}, {} steps; one thread: its own time\n\n",
             input.triangles.size(), obstacle.triangles.size(), steps);
  print(tasks);
  fmt::print("\nSubtrees built anew: {:.2f} of all triangles in all steps. {} bytes a triangle.\n",
             static_cast<double>(rebuilt_triangles) / static_cast<double>(input.triangles.size()),
             cloth.memory() / input.triangles.size());
  require_agreement(tasks);
  return rows_of(tasks, input.triangles.size());
}

}  // namespace tandem::bench
