#pragma once
#include <functional>
#include <string>
#include <vector>

#include "results.h"

namespace tandem::bench {

/// What a bench is asked for; 0 or empty: the bench's own choice.
struct Settings {
  std::vector<std::string> scenes;  ///< built-in names, or the bench's own
  std::vector<std::string> kinds;   ///< of pairs
  std::vector<std::string> contestants;
  std::vector<std::size_t> sizes;  ///< numbers of boxes
  std::vector<int> threads;
  int steps = 0;
  int repeat = 0;
  std::size_t bodies = 0;
  std::size_t poses = 0;
  bool quick = false;
};

/// Prints its tables to stdout and returns its rows. Throws std::invalid_argument for a setting it cannot use,
/// std::runtime_error when contestants disagree.
using Bench = std::function<Findings(const Settings&)>;

/// The paper's four scenes by executor: ms a step, ratio to sequential, contact hash.
std::vector<Row> scenes_bench(const Settings& settings);
/// The paper's Figures 3 to 7: measured on this machine's cores, simulated on more.
Findings figures_bench(const Settings& settings);
/// What the machinery between the two phases costs, and every executor on made-up and real loads.
std::vector<Row> flowgraph_bench(const Settings& settings);
/// Speed against error of the narrow phase and of other libraries, by kind of pair and how the two lie to each other.
std::vector<Row> narrowphase_bench(const Settings& settings);
/// Boxes in, overlapping pairs out: our methods and other libraries on typical worlds and on those made to break them.
std::vector<Row> broadphase_bench(const Settings& settings);
/// The whole detection step on recorded poses of the paper's scenes, beside FCL's and Bullet's collision worlds. A
/// scene is one of `peers_scene_names`, or a file of `tandem run --record`.
std::vector<Row> peers_bench(const Settings& settings);
std::vector<std::string> peers_scene_names();
/// Configurations and motions of robot arms among obstacles, and their clearance, beside FCL's manager.
std::vector<Row> planner_bench(const Settings& settings);
/// tandem::fcl::CollisionManager beside FCL's managers, operation by operation.
std::vector<Row> fcl_bench(const Settings& settings);
/// A tool of 10,000 triangles in a loop of 1 kHz against a scene of 500,000: the slowest queries, beside FCL's.
std::vector<Row> haptics_bench(const Settings& settings);
/// Times of impact of vertices on straight lines, each held against the exact one. Throws std::runtime_error on a miss.
std::vector<Row> vertex_impacts_bench(const Settings& settings);
/// A bed of spheres of all sizes beside a plain cell list and Bullet, and what it takes of memory.
std::vector<Row> grains_bench(const Settings& settings);
/// Steps with kept contacts: time against the true error of every answer, and whether it is within the bound told.
std::vector<Row> steps_bench(const Settings& settings);
/// Short steps by scene, size and executor, with workers that stay awake and without; small worlds in a host's loop.
std::vector<Row> short_steps_bench(const Settings& settings);
/// A sheet of cloth that folds onto a ball and itself: new vertices and pairs of triangles, beside FCL's updates.
std::vector<Row> cloth_bench(const Settings& settings);
/// Contacts of convex shapes with meshes of 6,000 triangles, beside FCL's; steps of bodies of all kinds.
std::vector<Row> round_meshes_bench(const Settings& settings);
/// Bounds on the depth of solids deep in each other, by family and by how many boxes of translations are looked at.
std::vector<Row> depths_bench(const Settings& settings);
/// Meshes of 10^3 to 5 * 10^6 triangles made ready for queries, beside Embree's hierarchies and FCL's.
std::vector<Row> building_bench(const Settings& settings);
/// Meshes of 10^3 to 5 * 10^6 triangles, built and asked for pairs and distances, beside FCL, Embree and CGAL. Throws
/// std::runtime_error where an exact contestant finds other pairs.
std::vector<Row> big_meshes_bench(const Settings& settings);
/// What it calls its worlds.
std::vector<std::string> broadphase_scenes();

}  // namespace tandem::bench
