// Convex hulls.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "shapes/face_table.h"
#include "shapes/ray_map.h"
#include "shapes/support_map.h"

namespace tandem {

namespace detail {

/// The convex hull of points, of any dimension: a point, a segment, a flat polygon or a polytope.
struct Hull {
  /// A facet: the polygon loop[first, first + count), counterclockwise from outside; normal . x <= offset for every
  /// vertex (the offset is the largest of these products). Faces coplanar to rounding are merged.
  struct Face {
    Vec3 normal;
    double offset;
    std::uint32_t first;
    std::uint32_t count;
  };
  /// An edge, from v[0] to v[1] in face[0]'s loop, reversed in face[1]'s. A segment's edge has no faces: {0, 0}.
  struct Edge {
    std::array<std::uint32_t, 2> v;
    std::array<std::uint32_t, 2> face;
  };

  // Members that most queries read come first, close together, to save cache misses.
  std::vector<Vec3> vertices;  ///< the extreme points, with the given bits, in the given order
  Vec3 inside = Vec3::Zero();  ///< an interior point: the mean of the vertices
  double inner_radius = 0;     ///< radius of a ball about it inside the hull
  SupportMap support;          ///< of the vertices; empty if there are at most 4
  RayMap rays;                 ///< of polytopes; else empty
  FaceTable face_table;        ///< of small polytopes; else empty
  SupportMap normals;          ///< of the faces' normals, if face_table is empty and there are more than 4 faces
  std::vector<Face> faces;     ///< empty below dimension 2
  std::vector<std::uint32_t> loop;
  std::vector<Edge> edges;
  std::vector<std::uint32_t> neighbour_first;  ///< for vertex i: neighbours[neighbour_first[i], neighbour_first[i + 1])
  std::vector<std::uint32_t> neighbours;       ///< for a polytope in cyclic order, counterclockwise from outside
  /// For a polytope: the face between a neighbour and the next one in cyclic order. Empty also if, because of rounding,
  /// the faces around a vertex form more than one ring: then neighbours are in no order.
  std::vector<std::uint32_t> neighbour_face;
  std::size_t memory() const;  ///< bytes

  int dimension = 0;  ///< 0 point, 1 segment, 2 flat polygon (two faces, back to back), 3 polytope
};

}  // namespace detail

using detail::Hull;

}  // namespace tandem
