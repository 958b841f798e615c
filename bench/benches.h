// The benches of tandem-bench and their settings.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "results.h"

namespace tandem::bench {

/// The settings of a bench, from the command line; 0 or empty: the bench's own choice.
struct Settings {
  std::vector<std::string> scenes;  ///< built-in names, or the bench's own
  std::vector<std::string> kinds;   ///< kinds of pairs
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

/// The four scenes of the paper by executor: ms a step, ratio to sequential, contact hash.
std::vector<Row> scenes_bench(const Settings& settings);
/// Figures 3 to 7 of the paper: measured on this machine's cores, simulated for more.
Findings figures_bench(const Settings& settings);
/// The overhead of the executors between the two phases; every executor on synthetic and real loads.
std::vector<Row> flowgraph_bench(const Settings& settings);
/// Speed against error of the narrow phase and of other libraries, by kind of pair and class of relative pose.
std::vector<Row> narrowphase_bench(const Settings& settings);
/// Broad phases: our methods and other libraries on typical worlds and on those made to break them.
std::vector<Row> broadphase_bench(const Settings& settings);
/// The whole detection step on recorded poses of the paper's scenes, beside FCL's and Bullet's collision worlds. A
/// scene is one of `peers_scene_names`, or a file of `tandem run --record`.
std::vector<Row> peers_bench(const Settings& settings);
std::vector<std::string> peers_scene_names();
/// A planner's queries of robot arms among obstacles: configurations, motions, clearance; beside FCL's manager.
std::vector<Row> planner_bench(const Settings& settings);
/// tandem::fcl::CollisionManager beside FCL's managers, operation by operation.
std::vector<Row> fcl_bench(const Settings& settings);
/// A robot's link among the occupied cells of an octree: FCL's octree, voxels, their surface as a mesh.
std::vector<Row> octrees_bench(const Settings& settings);
/// A tool of 10,000 triangles in a loop of 1 kHz against a scene of 500,000: the slowest queries, beside FCL's.
std::vector<Row> haptics_bench(const Settings& settings);
/// Times of impact of vertices on straight lines, each compared with the exact one. Throws std::runtime_error on a
/// miss.
std::vector<Row> vertex_impacts_bench(const Settings& settings);
/// A bed of spheres of all sizes beside a plain cell list and Bullet: time of a step and memory.
std::vector<Row> grains_bench(const Settings& settings);
/// Steps with kept contacts: time against the true error of every answer, and whether that is within the stated bound.
std::vector<Row> steps_bench(const Settings& settings);
/// Short steps by scene, size and executor, with and without workers that stay awake; small worlds in a host's loop.
std::vector<Row> short_steps_bench(const Settings& settings);
/// A piece of cloth that folds onto a ball and itself: new vertices and pairs of triangles, beside FCL's updates.
std::vector<Row> cloth_bench(const Settings& settings);
/// Contacts of convex shapes with meshes of 6,000 triangles, beside FCL's; steps of bodies of all kinds.
std::vector<Row> round_meshes_bench(const Settings& settings);
/// Bounds on the depth of solids deep in each other, by family and by the number of boxes of translations examined.
std::vector<Row> depths_bench(const Settings& settings);
/// Building the hierarchies of meshes of 10^3 to 5 * 10^6 triangles, beside Embree's and FCL's.
std::vector<Row> building_bench(const Settings& settings);
/// Meshes of 10^3 to 5 * 10^6 triangles, built and queried for pairs and distances, beside FCL, Embree and CGAL. Throws
/// std::runtime_error where an exact contestant finds other pairs.
std::vector<Row> big_meshes_bench(const Settings& settings);
/// The names of the worlds of the broad-phase bench.
std::vector<std::string> broadphase_scenes();

}  // namespace tandem::bench
