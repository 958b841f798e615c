#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "tandem/narrowphase/options.h"
#include "tandem/narrowphase/search.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// A triangle of A and one of B that intersect or are near each other.
struct NearTriangles {
  std::array<std::uint32_t, 2> triangles{};  ///< of A, of B
  double distance = 0;                       ///< metres; 0: they intersect or touch, exactly
  /// World, the nearest points; where they intersect the middle of what their boxes share.
  Vec3 point_a = Vec3::Zero(), point_b = Vec3::Zero();
};

/// Receives a pair when it is found, on the calling thread; false ends the search.
using NearTrianglesVisitor = std::function<bool(const NearTriangles&)>;

/// How a search for pairs of triangles is made.
struct NearOptions {
  /// Metres, finite, >= 0: pairs at most this far apart. 0: those that intersect, exactly.
  double clearance = 0;
  /// Ends the search (work_limit.h); null: none.
  const WorkLimit* limit = nullptr;
  /// How much of the search is done, [0, 1], rising, some hundred times at most, on the calling thread; empty: nobody
  /// asks.
  std::function<void(double part)> progress{};
};

/// Visits every pair of triangles of two shapes that is at most the clearance apart, each once; both a mesh or a
/// triangle without rounding. Nothing is kept: memory does not grow with the pairs. The order depends on the arguments
/// only. Whether two triangles intersect is exact, distances are right to rounding. Throws std::invalid_argument naming
/// what is wrong.
SearchEnd visit_triangles(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                          const NearTrianglesVisitor& visitor, const NearOptions& options = {});

/// A place where two meshes intersect or come near each other.
struct ClearanceZone {
  std::size_t pairs = 0;               ///< of triangles at most the clearance apart
  std::size_t intersecting_pairs = 0;  ///< of them
  /// Box in world axes about the nearest points of its pairs and what the boxes of those that intersect share.
  Bounds bounds{Vec3::Zero(), Vec3::Zero()};
  std::array<double, 2> area{};  ///< of its triangles of A and of B, each whole, m^2
  /// Its nearest pair; where some intersect the deepest of them, of which no translation of B shorter than its depth
  /// separates even these two triangles. Of equals the first by index.
  std::array<std::uint32_t, 2> triangles{};
  double signed_distance = 0;  ///< of that pair, metres: > 0 its distance, else minus its depth
  Vec3 point_a = Vec3::Zero(), point_b = Vec3::Zero();  ///< of that pair, world
  Vec3 normal = Vec3::Zero();                           ///< of that pair, unit, world, from A to B
};

/// The pairs of triangles at most the clearance apart by zones: connected components, where two pairs hang together if
/// their triangles of A are one or share a corner (of equal coordinates), and those of B, too. Four feet on a floor of
/// two triangles are four zones. The deepest or nearest zone first. Memory grows with the pairs, some 200 bytes each.
/// Throws as visit_triangles does, and WorkStopped where the limit is reached.
std::vector<ClearanceZone> clearance_zones(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                           const NearOptions& options);

/// How far B must be moved along a direction (of any length but 0; metres along it) to be apart from A and stay so
/// however much farther it is moved: the last touch along it, over all pairs of triangles of meshes. 0: they do not
/// touch now nor later; infinite: a half-space that it does not lead out of, as one within 1e-12 of its
/// plane. Before that they may be apart, too, as of a ring and what is moved through its hole; of convex shapes it is
/// the penetration depth along the direction.
/// There B touches A or is apart from it by no more than 1e-12 of the sizes; it is never told less than it is by more
/// than rounding.
///
/// By conservative advancement from far out (Mirtich 1996), best first over the hierarchies of meshes: a yes or no's
/// work, more or less. Throws std::invalid_argument for a direction that is not finite or 0 and for two half-spaces,
/// and WorkStopped where the options' limit is reached.
double separation_along(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& direction,
                        const NarrowPhaseOptions& options = {});

}  // namespace tandem
