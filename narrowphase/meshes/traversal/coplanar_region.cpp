// The coplanar triangles around a triangle.
#include "meshes/traversal/coplanar_region.h"

#include <algorithm>
#include <cmath>

#include "closed_forms/closed_forms.h"
#include "shapes/convex_view.h"
#include "tolerances.h"

namespace tandem {

bool lies_in_plane(const MeshModel& mesh, std::uint32_t t, const Vec3& normal, const Vec3& at, double slack) {
  const Corners c = mesh.corners(t);
  return std::all_of(c.begin(), c.end(), [&](const Vec3& v) { return std::abs(normal.dot(v - at)) <= slack; }) &&
         normal.dot(area_vector(c)) > 0;
}

// Breadth-first search over edges; unreached triangles lie beyond the border.
CoplanarRegion coplanar_region(const MeshModel& mesh, std::uint32_t t, const Vec3& n, std::size_t most, double slack) {
  const Corners own = mesh.corners(t);
  CoplanarRegion region{{t}, {}};
  std::vector<std::uint32_t>& flat = region.triangles;
  const auto is_known = [&](std::uint32_t i) { return std::find(flat.begin(), flat.end(), i) != flat.end(); };
  for (std::size_t i = 0; i < flat.size() && flat.size() < most; ++i)
    for (const std::uint32_t next : mesh.neighbours()[flat[i]])
      if (flat.size() < most && next != no_index && !is_known(next) && lies_in_plane(mesh, next, n, own[0], slack))
        flat.push_back(next);
  for (const std::uint32_t i : flat) {
    const Corners c = mesh.corners(i);
    for (std::size_t k = 0; k < 3; ++k)
      if (const std::uint32_t next = mesh.neighbours()[i][k]; next == no_index || !is_known(next))
        region.border.push_back({c[k], c[(k + 1) % 3]});
  }
  return region;
}

// Not by the sides of its edges: those of a sliver, all parallel, bound nothing along it.
bool contains_point(const Corners& triangle, const Vec3& p, double slack) {
  return point_distance(TriangleView(triangle), p).signed_distance <= slack;
}

double distance_to_region_border(const MeshModel& mesh, std::uint32_t t, const Vec3& n, const Vec3& p, double slack) {
  constexpr std::size_t most = 16;
  if (!contains_point(mesh.corners(t), p, slack)) return -1;
  double nearest = infinity;
  for (const auto& [from, to] : coplanar_region(mesh, t, n, most, slack).border) {
    const Vec3 edge = to - from;
    const double fraction = std::clamp((p - from).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - from - fraction * edge).norm());
  }
  return nearest;
}

}  // namespace tandem
