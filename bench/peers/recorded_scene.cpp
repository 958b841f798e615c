// Records the poses of scenes for the benches of whole steps.
#include "recorded_scene.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <functional>

#include "formats/record_file.h"
#include "progress.h"
#include "tandem/engine/builtin_scenes.h"
#include "tandem/engine/pipeline.h"
#include "tandem/engine/response.h"

namespace tandem::bench {
namespace {

constexpr std::array<PeersScene, 7> table{{
    {"3000-cubes", "boxes on a plane", "cubes-on-plane", 3000, false, 200},
    {"2500-spheres", "spheres on a plane", "spheres-on-plane", 2500, false, 200},
    {"1000-cubes", "boxes on a plane", "cubes-on-plane", 1000, false, 200},
    {"500-tori", "tori of 1152 triangles on a plane", "tori-on-plane", 500, false, 96},
    {"2000-tori-on-cones", "tori of 1152 triangles on a field of cones", "tori-on-cones", 2000, false, 16},
    {"500-screws-hulls", "bolts and nuts as convex hulls in a mesh bowl", "screws-in-bowl", 500, true, 96},
    {"500-screws-meshes", "bolts and nuts as meshes in a mesh bowl", "screws-in-bowl", 500, false, 96},
}};

/// The scene with its bodies, moving meshes replaced by the hulls of their vertices.
Scene with_hulls(const Scene& from) {
  Scene out;
  out.name = from.name;
  out.gravity = from.gravity;
  out.dt = from.dt;
  std::vector<bool> moves(from.shapes().size());
  for (std::uint32_t i = 0; i < from.indices(); ++i)
    if (from.is_static()[i] == 0) moves[from.shape_indices()[i]] = true;
  std::vector<ShapeId> ids;
  for (std::uint32_t k = 0; k < from.shapes().size(); ++k) {
    const Shape& shape = from.shapes()[k];
    const bool replaced = shape.kind() == ShapeKind::mesh && moves[k];
    const auto points = shape.vertices();
    ids.push_back(out.add_shape(replaced ? Shape(Convex{{points.begin(), points.end()}}) : shape,
                                std::string(from.shape_name(k))));
  }
  for (std::uint32_t i = 0; i < from.indices(); ++i)
    out.add_body({.shape = ids[from.shape_indices()[i]],
                  .pose = from.poses()[i],
                  .velocity = from.velocities()[i],
                  .angular_velocity = from.angular_velocities()[i],
                  .density = from.densities()[i],
                  .is_static = from.is_static()[i] != 0});
  return out;
}

/// Chooses the steps that are kept.
class Stretches {
 public:
  Stretches(std::size_t steps, std::size_t timed) {
    const std::size_t length = untimed_steps + stretch_steps;
    const std::size_t most = std::max<std::size_t>(1, steps / length);
    const std::size_t wanted = std::clamp<std::size_t>((timed + stretch_steps - 1) / stretch_steps, 1, most);
    // The middle of each of `wanted` equal ranges of steps.
    for (std::size_t k = 0; k < wanted; ++k) {
      const std::size_t part = steps / wanted;
      const std::size_t slack = part > length ? (part - length) / 2 : 0;
      first_.push_back(k * part + slack);
    }
  }
  void take(std::size_t step, const Scene& scene, std::vector<Stretch>& out) const {
    const auto after = std::upper_bound(first_.begin(), first_.end(), step);
    if (after == first_.begin()) return;
    const std::size_t first = *std::prev(after);
    if (step >= first + untimed_steps + stretch_steps) return;
    if (step == first) out.push_back({first, {}});
    out.back().poses.emplace_back(scene.poses().begin(), scene.poses().end());
  }

 private:
  std::vector<std::size_t> first_;
};

}  // namespace

std::span<const PeersScene> peers_scenes() { return table; }

RecordedScene simulate(const PeersScene& wanted, std::size_t bodies, std::size_t steps, std::size_t timed) {
  Scene scene = make_builtin_scene(wanted.builtin, bodies != 0 ? bodies : wanted.bodies);
  if (wanted.hulls) scene = with_hulls(scene);
  RecordedScene out{std::string(wanted.name), scene, steps, {}};
  const Stretches stretches(steps, timed);
  Pipeline pipeline({.answer = {.margin = recommended_margin(scene)}});
  Response response;
  Progress progress(wanted.name, steps);
  for (std::size_t step = 0; step < steps; ++step) {
    stretches.take(step, scene, out.stretches);
    pipeline.step(scene);
    response.step(scene, pipeline.contacts());
    progress.at(step + 1);
  }
  return out;
}

RecordedScene read_recorded(const std::string& file, std::size_t steps, std::size_t timed) {
  // The file is read twice: the number of steps is known at its end.
  std::size_t count = 0;
  RecordedStep read;
  for (RecordReader reader(file); count < steps && reader.next(read);) ++count;
  RecordReader reader(file);
  Scene scene = reader.scene();
  RecordedScene out{std::filesystem::path(file).stem().string(), scene, count, {}};
  const Stretches stretches(count, timed);
  for (std::size_t step = 0; step < count && reader.next(read); ++step) {
    for (const auto& [index, pose] : read.poses) scene.move(index, pose, Vec3::Zero(), Vec3::Zero());
    stretches.take(step, scene, out.stretches);
  }
  return out;
}

}  // namespace tandem::bench
