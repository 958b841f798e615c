// Normal cones of a mesh's features.
#include "meshes/contacts/normal_cone.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "shapes/triangle_fan.h"
#include "tolerances.h"

namespace tandem {
namespace {

using tolerance::flush;  // sine of an angle that counts as zero

// Does the triangle, which has the two vertices `ends` (representatives), have another one farther along n? Its own
// copies of the ends may differ from these by rounding.
bool has_higher_vertex(const MeshModel& mesh, std::uint32_t t, const std::array<std::uint32_t, 2>& ends,
                       const Vec3& n) {
  for (const std::uint32_t v : mesh.triangles[t]) {
    const std::uint32_t place = mesh.representative(v);
    if (place == ends[0] || place == ends[1]) continue;
    const Vec3 away = mesh.vertices[v] - mesh.vertices[ends[0]];
    if (n.dot(away) > flush * away.norm()) return true;
  }
  return false;
}

}  // namespace

// Goes from edge to edge about the corner, in both directions.
bool has_higher_neighbour(const MeshModel& mesh, std::uint32_t t, std::size_t k, const Vec3& n) {
  const std::uint32_t corner = mesh.representative(mesh.triangles[t][k]);
  for (const bool back : {true, false}) {
    TriangleCorner at{t, k};
    for (std::size_t i = 0; i < most_about_corner && at.corner < 3; ++i) {
      at = next_about_corner(mesh, at, back);
      if (at.triangle == no_index || at.triangle == t) break;
      if (has_higher_vertex(mesh, at.triangle, {corner, corner}, n)) return true;
    }
  }
  return false;
}

// For triangles that are not slivers, for which `flush` is a small fraction of an angle.
bool CornerNormals::find(const MeshModel& mesh, std::uint32_t t) {
  least_cosine_ = 1;
  const auto own = triangle_normal(mesh, t, tolerance::sliver_in_cone);
  if (!own) return false;
  normal_ = *own;
  for (std::size_t k = 0; k < 3; ++k)
    if (!go_around(mesh, t, k)) return false;
  least_cosine_ -= tolerance::cone_spare;
  return true;
}

std::optional<double> CornerNormals::kept_least_cosine(const MeshModel& mesh, std::uint32_t t) {
  return mesh.least_cosines().of(t, [&]() -> std::optional<double> {
    CornerNormals cones;
    if (!cones.find(mesh, t)) return std::nullopt;
    return cones.least_cosine();
  });
}

// Goes from edge k of t about its first corner back to t.
bool CornerNormals::go_around(const MeshModel& mesh, std::uint32_t t, std::size_t k) {
  std::array<Vec3, most_about_corner>& normals = normals_[k];
  std::size_t& count = count_[k];
  normals[0] = normal_;
  around_[k][0] = mesh.triangles[t][(k + 1) % 3];
  count = 1;
  for (TriangleCorner at = next_about_corner(mesh, {t, k}); at.triangle != t; at = next_about_corner(mesh, at)) {
    if (at.corner == 3 || count == most_about_corner) return false;
    const auto normal = triangle_normal(mesh, at.triangle, tolerance::sliver_in_cone);
    if (!normal) return false;
    least_cosine_ = std::min(least_cosine_, normal_.dot(*normal));
    normals[count] = *normal;
    around_[k][count++] = mesh.triangles[at.triangle][(at.corner + 1) % 3];
  }
  return true;
}

bool in_normal_cone(const MeshModel& mesh, std::uint32_t t, const Vec3& n, const Vec3& at, double slack) {
  const auto p = mesh.corners(t);
  std::array<double, 3> height;
  for (std::size_t k = 0; k < 3; ++k) height[k] = n.dot(p[k] - p[0]);
  const double top = *std::max_element(height.begin(), height.end());
  const double longest = std::max({(p[1] - p[0]).norm(), (p[2] - p[0]).norm(), (p[2] - p[1]).norm()});
  std::array<bool, 3> high;
  for (std::size_t k = 0; k < 3; ++k) high[k] = height[k] >= top - flush * longest;
  // A face of a solid has one normal, to the outside; a surface has two.
  if (high[0] && high[1] && high[2]) return !mesh.solid || n.dot((p[1] - p[0]).cross(p[2] - p[0])) >= 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t to = (k + 1) % 3;
    if (!high[k] || !high[to]) continue;
    // The surroundings of an edge's ends matter only near these.
    const std::uint32_t next = mesh.neighbours()[t][k];
    const auto& v = mesh.triangles[t];
    if (next != no_index && has_higher_vertex(mesh, next, {mesh.representative(v[k]), mesh.representative(v[to])}, n))
      return false;
    for (const std::size_t end : {k, to})
      if ((at - p[end]).norm() <= slack) return !has_higher_neighbour(mesh, t, end, n);
    return true;
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (high[k] && has_higher_neighbour(mesh, t, k, n)) return false;
  return true;
}

}  // namespace tandem
