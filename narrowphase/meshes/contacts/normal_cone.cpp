#include "meshes/contacts/normal_cone.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tolerances.h"

namespace tandem {
namespace {

using tolerance::flush;              // sine of an angle that is none
constexpr int most_neighbours = 64;  // about a corner

// False for slivers: beyond these `flush` is a small part of an angle.
bool normal_of(const MeshModel& mesh, std::uint32_t t, Vec3& n) {
  const auto p = mesh.corners(t);
  const Vec3 u = p[1] - p[0], v = p[2] - p[0], area = u.cross(v);
  const double length = area.norm();
  if (!(length > tolerance::sliver_in_cone * std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()})))
    return false;
  n = area / length;
  return true;
}

}  // namespace

// From edge to edge about the corner, both ways round.
bool has_higher_neighbour(const MeshModel& mesh, std::uint32_t t, std::size_t k, const Vec3& n) {
  const Vec3 corner = mesh.corners(t)[k];
  for (const bool forth : {true, false}) {
    std::uint32_t at = t;
    std::size_t c = k;
    for (int i = 0; i < most_neighbours; ++i) {
      const std::uint32_t next = mesh.neighbours[at][forth ? (c + 2) % 3 : c];
      if (next == no_index || next == t) break;
      const auto p = mesh.corners(next);
      std::size_t same = 3;
      for (std::size_t j = 0; j < 3; ++j) {
        if (p[j] == corner) same = j;
        const Vec3 away = p[j] - corner;
        if (n.dot(away) > flush * away.norm()) return true;
      }
      if (same == 3) break;
      at = next;
      c = same;
    }
  }
  return false;
}

bool TriangleCones::find(const MeshModel& mesh, std::uint32_t t) {
  least_cosine_ = 1;
  if (!normal_of(mesh, t, normal_)) return false;
  for (std::size_t k = 0; k < 3; ++k)
    if (!go_around(mesh, t, k)) return false;
  least_cosine_ -= tolerance::cone_spare;
  return true;
}

// From edge k of t about its first corner back to t.
bool TriangleCones::go_around(const MeshModel& mesh, std::uint32_t t, std::size_t k) {
  std::array<Vec3, most_>& normals = normals_[k];
  std::size_t& count = count_[k];
  normals[0] = normal_;
  around_[k][0] = mesh.triangles[t][(k + 1) % 3];
  count = 1;
  const std::uint32_t corner = mesh.triangles[t][k];
  for (std::uint32_t at = mesh.neighbours[t][k]; at != t;) {
    if (at == no_index || count == most_ || !normal_of(mesh, at, normals[count])) return false;
    least_cosine_ = std::min(least_cosine_, normal_.dot(normals[count]));
    const auto& next = mesh.triangles[at];
    const auto c = static_cast<std::size_t>(std::find(next.begin(), next.end(), corner) - next.begin());
    if (c == 3) return false;
    around_[k][count++] = next[(c + 1) % 3];
    at = mesh.neighbours[at][c];
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
  if (high[0] && high[1] && high[2]) return true;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t to = (k + 1) % 3;
    if (!high[k] || !high[to]) continue;
    // Along an edge what lies around its corners tells only of these.
    const std::uint32_t next = mesh.neighbours[t][k];
    if (next != no_index)
      for (const Vec3& v : mesh.corners(next))
        if (const Vec3 away = v - p[k]; n.dot(away) > flush * away.norm()) return false;
    for (const std::size_t end : {k, to})
      if ((at - p[end]).norm() <= slack) return !has_higher_neighbour(mesh, t, end, n);
    return true;
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (high[k] && has_higher_neighbour(mesh, t, k, n)) return false;
  return true;
}

}  // namespace tandem
