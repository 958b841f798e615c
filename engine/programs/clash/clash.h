// Clash detection among the mesh files of an assembly.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/shape.h"

namespace tandem::clash {

/// A mesh file of an assembly; all files share one frame.
struct Part {
  std::string file;
  Shape shape;
  Bounds bounds;
  std::string open;  ///< the reason why it is not a solid; empty for a solid
};

/// A connected zone of intersection of two surfaces: pairs of triangles that are neighbours.
struct Zone {
  std::size_t triangle_pairs = 0;
  Vec3 place = Vec3::Zero();  ///< of its deepest pair of triangles
  Bounds bounds{Vec3::Zero(), Vec3::Zero()};
};

/// Two meshes that intersect, or are at most the clearance apart.
struct Clash {
  std::size_t a = 0, b = 0;        ///< indices, a < b
  bool intersects = false;         ///< they touch or overlap, or one lies inside the other
  std::size_t triangle_pairs = 0;  ///< intersecting pairs of triangles, exact; 0 where one lies inside the other
  double distance = 0;             ///< in the files' unit; < 0: minus the depth
  Vec3 place = Vec3::Zero();       ///< the deepest contact, or the midpoint between the nearest points
  Vec3 normal = Vec3::Zero();      ///< unit, from a to b
  Status status = Status::ok;      ///< of the distance; `intersects` is exact
  double error_bound = 0;          ///< of the distance, where it is inexact
  std::size_t zone_count = 0;      ///< number of connected zones where the surfaces intersect
  std::vector<Zone> zones;         ///< the deepest of them, at most most_zones
};

inline constexpr std::size_t most_zones = 100;

struct Pair {
  std::size_t a, b;
};

/// Called each time another item is done, from any thread, never from two at once.
using Done = std::function<void(std::size_t done)>;

/// Reads all files, on all threads of the caller's arena. A closed mesh is a solid. Throws what read_mesh_file throws,
/// or InputError for a mesh that cannot be used.
std::vector<Part> read_parts(const std::vector<std::filesystem::path>& files, const Done& done);

/// Pairs whose boxes are at most the clearance apart, sorted.
std::vector<Pair> candidates(const std::vector<Part>& parts, double clearance);

/// The result for a pair; `near`: it is a clash.
struct Answer {
  bool near = false;
  Clash clash;
};
Answer answer(const std::vector<Part>& parts, const Pair& pair, double clearance);

/// Answers all of these pairs, on all threads of the caller's arena, the largest meshes first. Calls `report` with each
/// answer when it is known, from any thread, never from two at once.
void answer_all(const std::vector<Part>& parts, std::vector<Pair> pairs, double clearance,
                const std::function<void(const Pair&, const Answer&)>& report);

}  // namespace tandem::clash
