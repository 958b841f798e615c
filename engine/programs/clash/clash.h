#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/shape.h"

namespace tandem::clash {

/// A mesh file, in the frame that all of them share.
struct Part {
  std::string file;
  Shape shape;
  Bounds bounds;
  std::string open;  ///< why the inside does not count; empty for a solid
};

/// A place where two parts intersect: pairs of triangles that hang together.
struct Zone {
  std::size_t triangle_pairs = 0;
  Vec3 place = Vec3::Zero();  ///< of its deepest pair
  Bounds bounds{Vec3::Zero(), Vec3::Zero()};
};

/// Two parts that intersect, or are at most the clearance apart.
struct Clash {
  std::size_t a = 0, b = 0;        ///< parts, a < b
  bool intersects = false;         ///< they touch or overlap, or one lies in the other
  std::size_t triangle_pairs = 0;  ///< intersecting pairs of triangles, exact; 0 where one lies inside the other
  double distance = 0;             ///< of the files' unit; < 0: minus the depth
  Vec3 place = Vec3::Zero();       ///< of the deepest contact, or midway between the nearest points
  Vec3 normal = Vec3::Zero();      ///< unit, from a to b
  Status status = Status::ok;      ///< of the distance; whether they intersect is exact
  double error_bound = 0;          ///< on the distance, where it is inexact
  std::size_t zone_count = 0;      ///< places where their surfaces intersect
  std::vector<Zone> zones;         ///< of them the deepest, most_zones at most
};

inline constexpr std::size_t most_zones = 100;

struct Pair {
  std::size_t a, b;
};

/// Called when another of the work's items is done, from any thread, never from two at once.
using Done = std::function<void(std::size_t done)>;

/// Reads all files, on all threads of the caller's arena. A mesh that is closed is a solid. Throws what read_mesh_file
/// throws, or InputError for a mesh that is none.
std::vector<Part> read_parts(const std::vector<std::filesystem::path>& files, const Done& done);

/// Pairs whose boxes are at most the clearance apart, sorted.
std::vector<Pair> candidates(const std::vector<Part>& parts, double clearance);

/// What the pair is; `near` says whether it is a clash.
struct Answer {
  bool near = false;
  Clash clash;
};
Answer answer(const std::vector<Part>& parts, const Pair& pair, double clearance);

/// All of these pairs, on all threads of the caller's arena, the largest first. `tell` receives each answer when it is
/// there, from any thread, never from two at once.
void answer_all(const std::vector<Part>& parts, std::vector<Pair> pairs, double clearance,
                const std::function<void(const Pair&, const Answer&)>& tell);

}  // namespace tandem::clash
