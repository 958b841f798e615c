// The triangles that lie in the plane of one of them about it.
#pragma once
#include <cstdint>
#include <vector>

#include "shapes/posed_mesh.h"

namespace tandem {

struct Edge {
  Vec3 from, to;
};

struct CoplanarRegion {
  std::vector<std::uint32_t> triangles;  ///< connected by edges, the one asked for first
  std::vector<Edge> border;              ///< mesh's frame
};

/// The region about triangle t, of `most` triangles at most; corners lie in its plane to `slack`.
CoplanarRegion coplanar_region(const MeshModel& mesh, std::uint32_t t, std::size_t most, double slack);

/// Does a triangle lie in the plane through `at` with this normal (unit), not folded back?
bool lies_in_plane(const MeshModel& mesh, std::uint32_t t, const Vec3& normal, const Vec3& at, double slack);

/// How far p, a point of triangle t, lies at least from the border of the region about it, both but for `slack`; -1 if
/// p is not in t. Mesh's frame.
double distance_to_region_border(const MeshModel& mesh, std::uint32_t t, const Vec3& p, double slack);

}  // namespace tandem
