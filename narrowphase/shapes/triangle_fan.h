// The triangles of a mesh about a vertex, and their normals.
#pragma once
#include <algorithm>
#include <optional>

#include "shapes/mesh_model.h"

namespace tandem {

/// A triangle with one of its corners; beyond a border the triangle is no_index, the corner 3.
struct TriangleCorner {
  std::uint32_t triangle;
  std::size_t corner;
};

/// The most triangles about a corner that are visited.
inline constexpr std::size_t most_about_corner = 64;

/// The next triangle about a corner: across the edge that leaves the corner, or, `back`, across the one that arrives.
inline TriangleCorner next_about_corner(const MeshModel& mesh, const TriangleCorner& at, bool back = false) {
  const std::uint32_t next = mesh.neighbours()[at.triangle][back ? (at.corner + 2) % 3 : at.corner];
  if (next == no_index) return {no_index, 3};
  const std::uint32_t corner = mesh.representative(mesh.triangles[at.triangle][at.corner]);
  const auto& other = mesh.triangles[next];
  const auto same = [&](std::uint32_t v) { return mesh.representative(v) == corner; };
  return {next, static_cast<std::size_t>(std::find_if(other.begin(), other.end(), same) - other.begin())};
}

/// The unit normal of a triangle whose height over its longest side is more than `sliver` of that side; else none.
inline std::optional<Vec3> triangle_normal(const MeshModel& mesh, std::uint32_t t, double sliver) {
  const auto p = mesh.corners(t);
  const Vec3 u = p[1] - p[0], v = p[2] - p[0], area = u.cross(v);
  const double length = area.norm();
  if (!(length > sliver * std::max({u.squaredNorm(), v.squaredNorm(), (v - u).squaredNorm()}))) return {};
  return area / length;
}

}  // namespace tandem
