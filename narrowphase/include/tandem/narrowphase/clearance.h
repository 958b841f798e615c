// Triangles of two bodies within a clearance, and zones of them.
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
  /// The nearest points, world; where the triangles intersect, the centre of the intersection of their boxes.
  Vec3 point_a = Vec3::Zero(), point_b = Vec3::Zero();
};

/// Receives a pair when it is found, on the calling thread; false ends the search.
using NearTrianglesVisitor = std::function<bool(const NearTriangles&)>;

/// Options of a search for pairs of triangles.
struct NearOptions {
  /// Metres, finite, >= 0: the largest distance of a pair. 0: pairs that intersect, exactly.
  double clearance = 0;
  /// Ends the search (work_limit.h); null: none.
  const WorkLimit* limit = nullptr;
  /// Reports the fraction of the search done, [0, 1], increasing, at most some hundred times, on the calling thread;
  /// empty: no reports.
  std::function<void(double part)> progress{};
};

/// Visits every pair of triangles of two shapes that is at most the clearance apart, each once; both shapes a mesh or a
/// triangle without rounding. No list is kept: memory does not grow with the number of pairs. The order depends on the
/// arguments only. Whether two triangles intersect is exact, distances are right to rounding. Throws
/// std::invalid_argument naming what is wrong.
SearchEnd visit_triangles(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                          const NearTrianglesVisitor& visitor, const NearOptions& options = {});

/// A connected zone where two meshes intersect or come near each other.
struct ClearanceZone {
  std::size_t pairs = 0;               ///< pairs of triangles at most the clearance apart
  std::size_t intersecting_pairs = 0;  ///< of these, pairs that intersect
  /// A box in world axes around the nearest points of its pairs, and around the intersections of the boxes of those
  /// that intersect.
  Bounds bounds{Vec3::Zero(), Vec3::Zero()};
  std::array<double, 2> area{};  ///< area of its triangles of A and of B, each counted whole, m^2
  /// Its nearest pair; where some intersect, the deepest of these: no translation of B shorter than its depth separates
  /// even these two triangles. Of equals the first by index.
  std::array<std::uint32_t, 2> triangles{};
  double signed_distance = 0;  ///< of that pair, metres: > 0 its distance, else minus its depth
  Vec3 point_a = Vec3::Zero(), point_b = Vec3::Zero();  ///< of that pair, world
  Vec3 normal = Vec3::Zero();                           ///< of that pair, unit, world, from A to B
};

/// The zones of pairs of triangles at most the clearance apart: connected components, where two pairs are connected if
/// their triangles of A are the same or share a corner (of equal coordinates), and those of B, too. Four feet on a
/// floor of two triangles are four zones. Sorted from the deepest or nearest. Memory grows with the pairs, some 200
/// bytes each. Throws as visit_triangles does, and WorkStopped where the limit is reached.
std::vector<ClearanceZone> clearance_zones(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                           const NearOptions& options);

/// The length by which B must be translated along a direction (of any length but 0; metres along it) to be separated
/// from A and stay so for any longer translation: the last contact along it, over all pairs of triangles of meshes. 0:
/// they touch neither now nor later; infinite: a half-space from which the direction does not lead, also one within
/// 1e-12 of its plane. Before that length they may be separated, too, like a ring and a body moved through its hole;
/// for convex shapes it is the penetration depth along the direction. After the translation B touches A or is apart
/// from it by at most 1e-12 of the sizes; the length is never too short by more than rounding.
///
/// By conservative advancement from far out (Mirtich 1996), best first over the hierarchies of meshes: about the work
/// of a collision verdict. Throws std::invalid_argument for a direction that is not finite or 0 and for two
/// half-spaces, and WorkStopped where the options' limit is reached.
double separation_along(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, const Vec3& direction,
                        const NarrowPhaseOptions& options = {});

}  // namespace tandem
