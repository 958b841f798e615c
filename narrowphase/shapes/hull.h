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
  /// Facet: the polygon loop[first, first + count) counterclockwise seen from outside; normal . x <= offset holds for
  /// every vertex (the offset is the largest of them). Faces coplanar to rounding are one.
  struct Face {
    Vec3 normal;
    double offset;
    std::uint32_t first;
    std::uint32_t count;
  };
  /// From v[0] to v[1] in face[0]'s loop, the other way round in face[1]'s. A segment's edge has no faces: {0, 0}.
  struct Edge {
    std::array<std::uint32_t, 2> v;
    std::array<std::uint32_t, 2> face;
  };

  // First what is read of a hull in most queries, together: each line of memory that is in no cache is waited for.
  std::vector<Vec3> vertices;  ///< the extreme points, bits as given, in the order given
  Vec3 inside = Vec3::Zero();  ///< a point of the hull: the mean of its vertices
  double inner_radius = 0;     ///< of a ball about it that is in the hull
  SupportMap support;          ///< of the vertices; empty where there are at most 4
  RayMap rays;                 ///< of polytopes; empty of others
  FaceTable face_table;        ///< of small polytopes; empty of others
  SupportMap normals;          ///< of the faces' normals, where face_table has none and they are more than 4
  std::vector<Face> faces;     ///< empty below dimension 2
  std::vector<std::uint32_t> loop;
  std::vector<Edge> edges;
  std::vector<std::uint32_t> neighbour_first;  ///< of vertex i: neighbours[neighbour_first[i], neighbour_first[i + 1])
  std::vector<std::uint32_t> neighbours;       ///< of a polytope in turn, counterclockwise seen from outside
  /// Of a polytope: the face between a neighbour and the next in turn. Empty also where faces around a vertex are more
  /// than one ring, by rounding: then neighbours are in no order.
  std::vector<std::uint32_t> neighbour_face;
  std::size_t memory() const;  ///< bytes

  int dimension = 0;  ///< 0 point, 1 segment, 2 flat polygon (two faces, back to back), 3 polytope
};

}  // namespace detail

using detail::Hull;

}  // namespace tandem
