// The coplanar triangles around a triangle of a mesh.
#pragma once
#include <cstdint>
#include <vector>

#include "shapes/posed_mesh.h"

namespace tandem {

struct Edge {
  Vec3 from, to;
};

struct CoplanarRegion {
  std::vector<std::uint32_t> triangles;  ///< connected by edges, the given one first
  std::vector<Edge> border;              ///< mesh's frame
};

/// The region around triangle t with the normal n (unit; a sliver's may be any), of at most `most` triangles; corners
/// lie in its plane to `slack`.
CoplanarRegion coplanar_region(const MeshModel& mesh, std::uint32_t t, const Vec3& n, std::size_t most, double slack);

/// True if a triangle lies in the plane through `at` with this normal (unit), and is not folded back.
bool lies_in_plane(const MeshModel& mesh, std::uint32_t t, const Vec3& normal, const Vec3& at, double slack);

/// True if p lies in the triangle, to `slack`.
bool contains_point(const Corners& triangle, const Vec3& p, double slack);

/// A lower bound on the distance of p, a point of triangle t with the normal n (unit; a sliver's may be any), from the
/// border of the region, within `slack`; -1 if p is not in t. Mesh's frame.
double distance_to_region_border(const MeshModel& mesh, std::uint32_t t, const Vec3& n, const Vec3& p, double slack);

}  // namespace tandem
