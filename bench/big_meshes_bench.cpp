// Meshes by size, built and queried: pairs of intersecting triangles, of two meshes and of one with itself, distances
// of separated and overlapping meshes; beside FCL, Embree and CGAL.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <functional>
#include <stdexcept>

#include "benches.h"
#include "big_meshes/contestant.h"
#include "clocks.h"
#include "torus_meshes.h"

namespace tandem::bench {
namespace {

using Contestants = std::vector<std::unique_ptr<MeshContestant>>;

Mesh moved(Mesh mesh, const Pose& pose) {
  for (Vec3& v : mesh.vertices) v = pose * v;
  return mesh;
}

Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh out{a.vertices, a.triangles, false};
  const auto first = static_cast<std::uint32_t>(a.vertices.size());
  out.vertices.insert(out.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) out.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  return out;
}

Contestants contestants(const MeshesGiven& given, const std::vector<std::string>& wanted) {
  Contestants all;
  const auto is_wanted = [&](const char* name) {
    return wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end();
  };
  for (const int threads : {1, 2})
    if (is_wanted("tandem")) all.push_back(tandem_meshes(given, threads));
  if (is_wanted("FCL")) all.push_back(fcl_meshes(given));
#ifdef TANDEM_HAS_EMBREE
  for (const int threads : {1, 2})
    if (is_wanted("Embree")) all.push_back(embree_meshes(given, threads));
#endif
#ifdef TANDEM_HAS_CGAL
  if (is_wanted("CGAL")) all.push_back(cgal_meshes(given));
#endif
  std::erase_if(all, [&](const auto& c) {
    const bool is_too_large = given.a.triangles.size() > c->most_triangles();
    if (is_too_large) fmt::print("without {}, which is given {} triangles at most\n", c->name(), c->most_triangles());
    return is_too_large;
  });
  return all;
}

/// A query, run once; returns false if the contestant cannot answer it. Notes the answer in `more`, exactly in `hash`.
struct Question {
  std::string name;
  std::function<bool(MeshContestant&, Row&)> ask;
};

bool note_pairs(const std::optional<TrianglePairs>& pairs, Row& row) {
  if (!pairs) return false;
  row.more["pairs"] = pairs->size();
  row.hash = hash_of(*pairs);
  return true;
}
bool note_distance(const std::optional<double>& distance, Row& row) {
  if (!distance) return false;
  row.more["distance"] = *distance;
  return true;
}

std::vector<Question> questions() {
  return {
      {"built", [](MeshContestant& c, Row&) { return c.build(), true; }},
      {"pairs", [](MeshContestant& c, Row& row) { return note_pairs(c.pairs(), row); }},
      {"pairs with itself", [](MeshContestant& c, Row& row) { return note_pairs(c.self_pairs(), row); }},
      {"distance, apart",
       [](MeshContestant& c, Row& row) { return note_distance(c.distance(Pose::at(1.8, 0, 0)), row); }},
      {"distance, overlapping", [](MeshContestant& c, Row& row) { return note_distance(c.distance(Pose{}), row); }}};
}

std::vector<Row> ask(const Question& question, const Contestants& contestants, std::size_t size, int repeat) {
  std::vector<Row> rows;
  std::vector<MeshContestant*> those;
  for (const auto& c : contestants) {
    Row row;
    row.bench = "big-meshes";
    row.workload = question.name;
    row.contestant = c->name();
    row.threads = c->threads();
    row.n = size;
    // The first run, with cold caches; the only one where it takes long.
    const auto clock = row.threads == 1 ? cpu_ns : wall_ns;
    const double begin = clock();
    if (!question.ask(*c, row)) continue;
    if (repeat == 0) row.time.add(clock() - begin);
    rows.push_back(row);
    those.push_back(c.get());
  }
  for (int r = 0; r < repeat; ++r)
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const auto clock = rows[k].threads == 1 ? cpu_ns : wall_ns;
      const double begin = clock();
      question.ask(*those[k], rows[k]);
      rows[k].time.add(clock() - begin);
    }
  // All exact contestants must have found the same.
  for (std::size_t k = 0; k < rows.size(); ++k) {
    rows[k].more["agrees"] = rows[k].hash == rows[0].hash;
    if (those[k]->is_exact() && rows[k].hash != rows[0].hash)
      throw std::runtime_error(fmt::format("{}, {} triangles: {} found other pairs than {}", question.name, size,
                                           rows[k].contestant, rows[0].contestant));
  }
  return rows;
}

void print(const Question& question, const std::vector<Row>& rows) {
  fmt::print("  {}\n", question.name);
  for (const Row& row : rows) {
    fmt::print("    {:20}{:3} thread{}{:12.3f} ms{:10.3f}{:10.3f}", row.contestant, row.threads,
               row.threads == 1 ? " " : "s", row.time.median() / 1e6, row.time.quantile(0.1) / 1e6,
               row.time.quantile(0.9) / 1e6);
    if (row.more.contains("pairs")) fmt::print("  {} pairs", row.more["pairs"].get<std::size_t>());
    if (row.more.contains("distance")) fmt::print("  {:.6g} m", row.more["distance"].get<double>());
    if (row.more.contains("bytes"))
      fmt::print("  {:.1f} bytes a triangle", row.more["bytes"].get<double>() / static_cast<double>(row.n));
    fmt::print("{}\n", row.more["agrees"].get<bool>() ? "" : ", others than the first");
  }
  std::fflush(stdout);  // the next may take minutes
}

void measure(std::size_t size, const Settings& settings, std::vector<Row>& all) {
  // Poses: tubes that cross; moved, so that they lie side by side.
  Pose across;
  across.rotation = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  across.translation = Vec3(1, 0.1, 0.05);
  const Mesh a = bumpy_torus(size), b = moved(a, across), half = bumpy_torus(size / 2),
             both = joined(half, moved(half, across));
  fmt::print("\n{} triangles\n", a.triangles.size());
  const Contestants all_of_size = contestants({a, b, both}, settings.contestants);
  const int by_size = size > 2'000'000 ? 0 : size > 200'000 ? 1 : size > 20'000 ? 3 : 15;
  const int repeat = settings.repeat != 0 ? settings.repeat : by_size;
  for (const auto& c : all_of_size) c->build_all();
  for (const Question& question : questions()) {
    std::vector<Row> rows = ask(question, all_of_size, a.triangles.size(), repeat);
    if (question.name == "built")
      for (std::size_t k = 0; k < rows.size(); ++k) rows[k].more["bytes"] = all_of_size[k]->memory();
    print(question, rows);
    all.insert(all.end(), rows.begin(), rows.end());
  }
}

}  // namespace

std::vector<Row> big_meshes_bench(const Settings& settings) {
  const std::vector<std::size_t> sizes = mesh_sizes(settings);
  std::vector<Row> rows;
  fmt::print("Two tori of so many triangles, and one mesh of half as many twice, which meets itself.\n");
#ifndef TANDEM_HAS_EMBREE
  fmt::print("Without Embree: libembree-dev was not found when this was built.\n");
#endif
#ifndef TANDEM_HAS_CGAL
  fmt::print("Without CGAL: libcgal-dev was not found when this was built.\n");
#endif
  for (const std::size_t size : sizes) measure(size, settings, rows);
  return rows;
}

}  // namespace tandem::bench
