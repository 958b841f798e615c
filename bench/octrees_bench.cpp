// A robot's link among the occupied cells of an octree, as a depth camera's map has them: FCL's octree, voxels, and the
// voxels' surface as a mesh. The same cells and poses in one process, in turn.
#include <fcl/config.h>

#include "benches.h"

#if FCL_HAVE_OCTOMAP
#include <fcl/geometry/octree/octree.h>
#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/geometry/shape/cylinder.h>
#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "clocks.h"
#include "tandem/fcl/convert.h"
#include "tandem/fcl/octree_shape.h"
#include "tandem/narrowphase/narrow_phase.h"
#include "tandem/narrowphase/shape_makers.h"

namespace tandem::bench {
namespace {

constexpr double cell = 0.05;
using Cells = std::vector<std::array<std::int32_t, 3>>;

/// About n cells of a room 8 m wide: its floor, rough and two cells thick, and the surfaces of boxes that stand on it.
Cells scanned_room(std::size_t n) {
  std::mt19937 random(1);
  const auto below = [&](int most) { return static_cast<std::int32_t>(random() % static_cast<unsigned>(most)); };
  Cells cells;
  constexpr std::int32_t wide = 160;
  for (std::int32_t i = 0; i < wide * wide; ++i)
    for (std::int32_t z = below(2); z >= 0; --z) cells.push_back({i % wide, i / wide, z});
  while (cells.size() < n) {
    const std::array<std::int32_t, 3> size{4 + below(20), 4 + below(20), 4 + below(30)};
    const std::array<std::int32_t, 3> at{below(wide - 24), below(wide - 24), 1};
    for (std::int32_t x = 0; x < size[0]; ++x)
      for (std::int32_t y = 0; y < size[1]; ++y)
        for (std::int32_t z = 0; z < size[2]; ++z)
          if (x == 0 || y == 0 || x + 1 == size[0] || y + 1 == size[1] || z + 1 == size[2])
            cells.push_back({at[0] + x, at[1] + y, at[2] + z});
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  std::shuffle(cells.begin(), cells.end(), random);
  return cells;
}

std::shared_ptr<octomap::OcTree> octomap_of(const Cells& cells) {
  auto tree = std::make_shared<octomap::OcTree>(cell);
  for (const auto& [x, y, z] : cells)
    tree->updateNode(
        octomap::OcTreeKey(static_cast<octomap::key_type>(32768 + x), static_cast<octomap::key_type>(32768 + y),
                           static_cast<octomap::key_type>(32768 + z)),
        true, true);
  tree->updateInnerOccupancy();
  tree->prune();
  return tree;
}

struct Link {
  std::string name;
  std::shared_ptr<::fcl::CollisionGeometryd> theirs;
  Shape ours;
};

std::vector<Link> links() {
  std::vector<Link> all;
  const auto add = [&](const std::string& name, const std::shared_ptr<::fcl::CollisionGeometryd>& geometry) {
    all.push_back({name, geometry, *tandem::fcl::to_shape<double>(*geometry)});
  };
  add("capsule", std::make_shared<::fcl::Capsuled>(0.06, 0.35));
  add("box", std::make_shared<::fcl::Boxd>(0.1, 0.12, 0.4));
  add("cylinder", std::make_shared<::fcl::Cylinderd>(0.06, 0.4));
  return all;
}

struct Placed {
  Pose ours;
  ::fcl::Transform3d theirs;
};

std::vector<Placed> poses(std::size_t count) {
  std::mt19937 random(2);
  const auto number = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
  std::vector<Placed> all;
  for (std::size_t i = 0; i < count; ++i) {
    Placed placed;
    const Quat turn = Quat(number() - 0.5, number() - 0.5, number() - 0.5, number() + 0.1).normalized();
    placed.ours = Pose::from(turn, Vec3(8 * number(), 8 * number(), 0.1 + 1.4 * number()));
    placed.theirs = ::fcl::Transform3d::Identity();
    placed.theirs.linear() = placed.ours.rotation;
    placed.theirs.translation() = placed.ours.translation;
    all.push_back(placed);
  }
  return all;
}

/// A contestant for one query, answered by 0 or 1 (yes/no), or by a distance, 0 if the shapes overlap.
struct Entrant {
  std::string name;
  std::function<double(const Link&, const Placed&)> answer;
};

void race(const std::string& workload, const Link& link, const std::vector<Placed>& placed,
          const std::vector<Entrant>& entrants, int rounds, double slack, std::size_t cells, std::vector<Row>& rows) {
  std::vector<Samples> times(entrants.size());
  std::vector<std::vector<double>> answers(entrants.size(), std::vector<double>(placed.size()));
  for (int round = 0; round < rounds; ++round)
    for (std::size_t who = 0; who < entrants.size(); ++who) {
      const double begin = cpu_ns();
      for (std::size_t i = 0; i < placed.size(); ++i) answers[who][i] = entrants[who].answer(link, placed[i]);
      times[who].add((cpu_ns() - begin) / static_cast<double>(placed.size()));
    }
  double sum = 0;
  for (const double answer : answers[0]) sum += answer;
  fmt::print("  {:22}", workload);
  for (std::size_t who = 0; who < entrants.size(); ++who) {
    std::size_t others = 0;
    for (std::size_t i = 0; i < placed.size(); ++i) others += !(std::abs(answers[who][i] - answers[0][i]) <= slack);
    fmt::print("  {} {:.0f} ns ({} differ)", entrants[who].name, times[who].median(), others);
    Row row;
    row.bench = "octrees";
    row.workload = workload;
    row.contestant = entrants[who].name;
    row.n = cells;
    row.time = times[who];
    row.more = {{"queries", placed.size()}, {"differ", others}, {"ratio", times[who].median() / times[0].median()}};
    rows.push_back(std::move(row));
  }
  fmt::print("  mean answer {:.4f}\n", sum / static_cast<double>(placed.size()));
}

double timed(const std::function<void()>& work) {
  const double begin = cpu_ns();
  work();
  return (cpu_ns() - begin) / 1e6;
}

}  // namespace

std::vector<Row> octrees_bench(const Settings& settings) {
  const std::size_t wanted = settings.sizes.empty() ? 100'000 : settings.sizes[0];
  const Cells cells = scanned_room(wanted);
  std::optional<Shape> voxels, mesh;
  std::shared_ptr<octomap::OcTree> tree;
  const double ms_tree = timed([&] { tree = octomap_of(cells); });
  const ::fcl::OcTreed octree(tree);
  const double ms_voxels = timed([&] { voxels = tandem::voxels(cells, cell); });
  const double ms_octree = timed([&] { voxels = tandem::fcl::to_voxels(octree); });
  const double ms_mesh = timed([&] { mesh = voxel_mesh(cells, cell); });
  const double n = static_cast<double>(cells.size());
  fmt::print(
      "{} cells, {} leaves; made in ms: octomap {:.1f}, voxels {:.1f} (of octomap's tree {:.1f}), mesh {:.1f}\n"
      "bytes a cell: octomap {:.1f}, voxels {:.1f}, mesh {:.1f}\n",
      cells.size(), voxels->cells().size(), ms_tree, ms_voxels, ms_octree, ms_mesh,
      static_cast<double>(tree->memoryUsage()) / n, static_cast<double>(voxels->memory()) / n,
      static_cast<double>(mesh->memory()) / n);
  const NarrowPhase narrow;
  const auto ask = [&](const Shape& world, Request request) {
    return [&narrow, &world, request](const Link& link, const Placed& at) {
      const PairAnswer answer = narrow.solve(link.ours, at.ours, world, Pose{}, request);
      return request == Request::collide ? static_cast<double>(answer.collide) : std::max(0.0, answer.signed_distance);
    };
  };
  const ::fcl::Transform3d still = ::fcl::Transform3d::Identity();
  const Entrant their_collide{"FCL octree", [&](const Link& link, const Placed& at) {
                                ::fcl::CollisionResultd result;
                                ::fcl::collide(link.theirs.get(), at.theirs, &octree, still,
                                               ::fcl::CollisionRequestd(1, false), result);
                                return static_cast<double>(result.isCollision());
                              }};
  const Entrant their_distance{"FCL octree", [&](const Link& link, const Placed& at) {
                                 ::fcl::DistanceResultd result;
                                 ::fcl::distance(link.theirs.get(), at.theirs, &octree, still,
                                                 ::fcl::DistanceRequestd(false), result);
                                 return std::max(0.0, result.min_distance);
                               }};
  std::vector<Row> rows;
  const std::vector<Placed> placed = poses(settings.quick ? 300 : 3000);
  const int rounds = settings.repeat > 0 ? settings.repeat : settings.quick ? 2 : 5;
  for (const Link& link : links()) {
    race(link.name + ", yes/no", link, placed,
         {{"voxels", ask(*voxels, Request::collide)}, their_collide, {"mesh", ask(*mesh, Request::collide)}}, rounds, 0,
         cells.size(), rows);
    constexpr double fcl_error = 1e-4;  // of its distances
    std::vector<Placed> apart;          // FCL computes no depth
    for (const Placed& at : placed)
      if (apart.size() < placed.size() / 3 && !narrow.solve(link.ours, at.ours, *voxels, {}, Request::collide).collide)
        apart.push_back(at);
    race(link.name + ", distance", link, apart,
         {{"voxels", ask(*voxels, Request::distance)}, their_distance, {"mesh", ask(*mesh, Request::distance)}}, rounds,
         fcl_error, cells.size(), rows);
  }
  return rows;
}

}  // namespace tandem::bench
#else
namespace tandem::bench {
std::vector<Row> octrees_bench(const Settings&) { return {}; }
}  // namespace tandem::bench
#endif  // FCL_HAVE_OCTOMAP
