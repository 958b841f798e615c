// First impacts of vertices that move on straight lines.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "tandem/narrowphase/part_runner.h"
#include "tandem/narrowphase/pose.h"

namespace tandem {

// Continuous collision detection of vertices on straight lines: every vertex moves from its position at t = 0 to that
// at t = 1 at constant speed, as in a step of cloth or of a deforming body. Features are closed sets, touching counts,
// at t = 0 and t = 1 too; degenerate triangles and edges are segments and points. Coordinates are finite and at most
// 1e30, else std::invalid_argument.

struct ImpactOptions {
  /// The largest distance of two features when an impact is reported, relative to the longest motion of a vertex of one
  /// relative to a vertex of the other; [0, 0.1]. 0: to rounding.
  double tolerance = 1e-6;
  /// Distance at which features count as touching; metres, [0, 1e30].
  double separation = 0;
};

/// The first impact of two features, for the real numbers that the coordinates are. No `hit`: they are farther apart
/// than `separation` at every t in [0, 1]; this is proven, whatever the rounding. A `hit`: so they are at every time
/// before `t`, and at `t` the distance is at most `gap`. gap - separation is within the tolerance or 1e-13 of the
/// coordinates' differences, unless the search was given up after 200 rounds.
struct VertexImpact {
  bool hit = false;
  double t = 1;    ///< [0, 1]: at or before the first impact; 1 without one
  double gap = 0;  ///< metres, >= 0: an upper bound on the distance at `t`; 0 without a hit
};

/// Three corners of a triangle, or two ends of an edge, at one time.
using TriangleCorners = std::array<Vec3, 3>;
using EdgeEnds = std::array<Vec3, 2>;

/// The first impact of a point and a triangle.
VertexImpact point_triangle_impact(const Vec3& point_from, const TriangleCorners& triangle_from, const Vec3& point_to,
                                   const TriangleCorners& triangle_to, const ImpactOptions& options = {});
/// The first impact of two edges.
VertexImpact edge_edge_impact(const EdgeEnds& a_from, const EdgeEnds& b_from, const EdgeEnds& a_to,
                              const EdgeEnds& b_to, const ImpactOptions& options = {});

/// The vertices of a mesh before and after a step, as many of each.
struct MovingVertices {
  std::span<const Vec3> from, to;
};

/// A candidate pair, by the indices of the vertices.
struct PointTriangle {
  std::uint32_t point;                    ///< of the first mesh
  std::array<std::uint32_t, 3> triangle;  ///< of the second
};
struct EdgeEdge {
  std::array<std::uint32_t, 2> a, b;  ///< of the first, of the second
};

/// The impacts of all candidates, impacts[i] of pairs[i] (as many of each). The two meshes may be the same, but
/// vertices that a candidate's features share touch at t = 0. `parts` distributes the work over threads; the answers do
/// not depend on it. Throws std::invalid_argument that names the vertex or the candidate.
void point_triangle_impacts(const MovingVertices& points, const MovingVertices& triangles,
                            std::span<const PointTriangle> pairs, std::span<VertexImpact> impacts,
                            const ImpactOptions& options = {}, const PartRunner& parts = {});
void edge_edge_impacts(const MovingVertices& a, const MovingVertices& b, std::span<const EdgeEdge> pairs,
                       std::span<VertexImpact> impacts, const ImpactOptions& options = {},
                       const PartRunner& parts = {});

/// Pairs of features of two meshes that may touch.
struct ImpactCandidates {
  std::span<const PointTriangle> points_of_a;  ///< a point of A, a triangle of B
  std::span<const PointTriangle> points_of_b;  ///< a point of B, a triangle of A
  std::span<const EdgeEdge> edges;
};

enum class ImpactKind : std::uint8_t { point_of_a, point_of_b, edges };

struct MeshImpact {
  VertexImpact impact;
  ImpactKind kind;      ///< the list of candidates that it is in
  std::uint32_t index;  ///< its index in that list
};

/// The first impact of two meshes: no candidates touch before its t. Of several at the same t the first listed. Faster
/// than all impacts, since candidates are followed only up to the first impact found among them, a few hundred at a
/// time.
std::optional<MeshImpact> first_impact(const MovingVertices& a, const MovingVertices& b,
                                       const ImpactCandidates& candidates, const ImpactOptions& options = {},
                                       const PartRunner& parts = {});

}  // namespace tandem
