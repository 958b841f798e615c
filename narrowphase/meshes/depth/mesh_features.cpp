// Coplanar faces and straight edges of a mesh, found on demand.
#include "meshes/depth/mesh_features.h"

#include "shapes/triangle_fan.h"
#include "shapes/unit_vector.h"

namespace tandem {
namespace {

constexpr std::size_t most = 64;  // triangles of a face, edges of a line

}  // namespace

const CoplanarRegion& MeshFeatures::face(std::uint32_t t) {
  const auto [place, fresh] = face_of_.try_emplace(t, faces_.size());
  if (!fresh) return faces_[place->second];
  faces_.push_back(coplanar_region(mesh_, t, unit(area_vector(mesh_.corners(t))), most, slack_));
  const std::vector<std::uint32_t>& triangles = faces_.back().triangles;
  if (triangles.size() < most)  // else the face would depend on the triangle it starts from
    for (const std::uint32_t i : triangles) face_of_[i] = faces_.size() - 1;
  return faces_.back();
}

const Edge& MeshFeatures::straight_edge(std::uint32_t t, std::size_t k) {
  const auto [place, fresh] = edges_.try_emplace({t, static_cast<std::uint32_t>(k)});
  if (fresh) {
    const Corners p = mesh_.corners(t);
    const Vec3 along = unit(p[(k + 1) % 3] - p[k]);
    place->second = {end_of_line(t, k, -along), end_of_line(t, (k + 1) % 3, along)};
  }
  return place->second;
}

bool MeshFeatures::is_edge(std::uint32_t t, std::size_t k) const {
  const std::uint32_t next = mesh_.neighbours()[t][k];
  if (next == no_index) return true;
  if (next < t) return false;
  const Corners p = mesh_.corners(t);
  return !lies_in_plane(mesh_, next, unit(area_vector(p)), p[0], slack_);
}

// From a corner of t straight on, from edge to edge.
Vec3 MeshFeatures::end_of_line(std::uint32_t t, std::size_t corner, const Vec3& along) const {
  const Vec3 begin = mesh_.corners(t)[corner];
  for (std::size_t step = 0; step < most && next_on_line(t, corner, begin, along); ++step) {
  }
  return mesh_.corners(t)[corner];
}

// Searches among the edges about the corner.
bool MeshFeatures::next_on_line(std::uint32_t& t, std::size_t& corner, const Vec3& begin, const Vec3& along) const {
  const Vec3 here = mesh_.corners(t)[corner];
  TriangleCorner at{t, corner};
  for (std::size_t i = 0; i < most_about_corner; ++i) {
    const Corners p = mesh_.corners(at.triangle);
    for (const std::size_t other : {(at.corner + 1) % 3, (at.corner + 2) % 3}) {
      const Vec3 away = p[other] - begin;
      if (!(along.dot(p[other] - here) > slack_) || (away - along.dot(away) * along).norm() > slack_) continue;
      t = at.triangle, corner = other;
      return true;
    }
    at = next_about_corner(mesh_, at);
    if (at.corner == 3 || at.triangle == t) return false;
  }
  return false;
}

}  // namespace tandem
