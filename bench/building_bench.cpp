// Building the hierarchies of meshes of all sizes, beside Embree's of the same triangles and FCL's.
#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "benches.h"
#include "clocks.h"
#include "fcl_model.h"
#include "tandem/narrowphase/build_options.h"
#include "tandem/narrowphase/shape.h"
#include "torus_meshes.h"
#ifdef TANDEM_HAS_EMBREE
#include <embree3/rtcore.h>
#endif

namespace tandem::bench {
namespace {

#ifdef TANDEM_HAS_EMBREE
class EmbreeBuilder {
 public:
  EmbreeBuilder(const Mesh& mesh, RTCBuildQuality quality, int threads)
      : mesh_(mesh), quality_(quality), device_(rtcNewDevice(("threads=" + std::to_string(threads)).c_str())) {
    for (const Vec3& v : mesh.vertices) places_.push_back(v.cast<float>());
    places_.emplace_back(0, 0, 0);  // Embree reads beyond the last vertex
  }
  EmbreeBuilder(const EmbreeBuilder&) = delete;
  EmbreeBuilder& operator=(const EmbreeBuilder&) = delete;
  ~EmbreeBuilder() { rtcReleaseDevice(device_); }

  void build() const {
    const RTCScene scene = rtcNewScene(device_);
    rtcSetSceneBuildQuality(scene, quality_);
    const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, places_.data(), 0,
                               sizeof places_[0], mesh_.vertices.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh_.triangles.data(), 0,
                               sizeof mesh_.triangles[0], mesh_.triangles.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    rtcReleaseScene(scene);
  }

 private:
  const Mesh& mesh_;
  const RTCBuildQuality quality_;
  const RTCDevice device_;
  std::vector<Eigen::Vector3f> places_;
};
#endif

struct Task {
  std::string contestant;
  int threads;
  std::function<void()> run;
  Samples wall{}, cpu{};
};

void run(Task& task) {
  const double wall = wall_ns(), cpu = process_cpu_ns();
  task.run();
  task.wall.add(wall_ns() - wall);
  task.cpu.add(process_cpu_ns() - cpu);
}

// The shape takes the mesh, so a copy is made before the clock starts.
void build_tandem(std::optional<Mesh>& spare, const Mesh& mesh, const PartRunner& parts) {
  const Shape shape(spare ? std::move(*spare) : Mesh(mesh), BuildOptions{.parts = parts});
  spare.reset();
}

std::vector<Task> tasks_of(const Mesh& mesh, std::optional<Mesh>& spare,
                           [[maybe_unused]] std::vector<std::shared_ptr<void>>& held) {
  const PartRunner at_once = [](std::size_t parts, const auto& part) {
    tbb::parallel_for(std::size_t{0}, parts, part);
  };
  std::vector<Task> tasks{{"tandem", 1, [&] { build_tandem(spare, mesh, {}); }},
                          {"tandem", 2, [&, at_once] { build_tandem(spare, mesh, at_once); }}};
#ifdef TANDEM_HAS_EMBREE
  for (const auto& [name, quality] :
       {std::pair("Embree, fast", RTC_BUILD_QUALITY_LOW), std::pair("Embree", RTC_BUILD_QUALITY_MEDIUM)})
    for (const int threads : {1, 2}) {
      const auto builder = std::make_shared<EmbreeBuilder>(mesh, quality, threads);
      held.push_back(builder);
      tasks.push_back({name, threads, [builder] { builder->build(); }});
    }
#endif
  constexpr std::size_t most_for_fcl = 1'000'000;
  if (mesh.triangles.size() <= most_for_fcl) tasks.push_back({"FCL, OBBRSS", 1, [&] { fcl_model(mesh); }});
  return tasks;
}

void measure(const std::string& workload, const Mesh& mesh, int repeat, std::vector<Row>& rows) {
  std::optional<Mesh> spare;
  std::vector<std::shared_ptr<void>> held;
  std::vector<Task> tasks = tasks_of(mesh, spare, held);
  for (int r = 0; r <= repeat; ++r)
    for (Task& task : tasks) {
      if (task.contestant == "tandem") spare = mesh;
      run(task);
      if (r == 0) task.wall = {}, task.cpu = {};  // the first run has cold caches: not counted
    }
  const ShapeMemory memory = Shape(mesh).memory_by_part();
  const auto count = static_cast<double>(mesh.triangles.size());
  const auto bytes = [&](std::size_t all) { return static_cast<double>(all) / count; };
  fmt::print("\n{}, {} triangles; bytes a triangle: {:.1f} (surface {:.1f}, adjacency {:.1f}, hierarchy {:.1f})\n",
             workload, mesh.triangles.size(), bytes(memory.total()), bytes(memory.surface), bytes(memory.adjacency),
             bytes(memory.hierarchy));
  fmt::print("{:16}{:>8}{:>12}{:>10}{:>10}{:>12}{:>14}{:>10}\n", "", "threads", "wall, ms", "p10", "p90", "cpu, ms",
             "ns a triangle", "ratio");
  for (const Task& t : tasks) {
    fmt::print("{:16}{:8}{:12.2f}{:10.2f}{:10.2f}{:12.2f}{:14.1f}{:10.2f}\n", t.contestant, t.threads,
               t.wall.median() / 1e6, t.wall.quantile(0.1) / 1e6, t.wall.quantile(0.9) / 1e6, t.cpu.median() / 1e6,
               t.cpu.median() / count, t.cpu.median() / tasks[0].cpu.median());
    Row& row = rows.emplace_back();
    row.bench = "building";
    row.workload = workload;
    row.contestant = t.contestant;
    row.threads = t.threads;
    row.n = mesh.triangles.size();
    row.time = t.threads == 1 ? t.cpu : t.wall;
    row.more = {{"cpu_ns", t.cpu.median()}};
    if (t.contestant == "tandem") row.more["bytes"] = memory.total();
  }
}

}  // namespace

std::vector<Row> building_bench(const Settings& settings) {
  const std::vector<std::size_t> sizes = mesh_sizes(settings);
  std::vector<Row> rows;
  fmt::print(
      "Meshes made ready for queries. cpu: of all threads together; ratio: of that, to tandem's on one thread\n");
  for (const std::size_t size : sizes) {
    const int repeat = settings.repeat != 0 ? settings.repeat : size > 2'000'000 ? 3 : size > 200'000 ? 7 : 15;
    const Mesh mesh = bumpy_torus(size);
    measure("torus", mesh, repeat, rows);
    measure("soup", soup_of(mesh), repeat, rows);
  }
  return rows;
}

}  // namespace tandem::bench
