// The flat faces and straight edges of a mesh, however they are divided into triangles.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "meshes/traversal/coplanar_region.h"

namespace tandem {

/// Faces and edges found on demand; in the mesh's frame.
class MeshFeatures {
 public:
  /// `slack`: the distance of corners from a plane or line that counts as zero, metres.
  MeshFeatures(const MeshModel& mesh, double slack) : mesh_(mesh), slack_(slack) {}

  /// The coplanar region about a triangle.
  const CoplanarRegion& face(std::uint32_t t);

  /// The straight line of edges that contains a triangle's edge k.
  const Edge& straight_edge(std::uint32_t t, std::size_t k);

  /// True if the surface bends at edge k, for the first of its two triangles.
  bool is_edge(std::uint32_t t, std::size_t k) const;

 private:
  Vec3 end_of_line(std::uint32_t t, std::size_t corner, const Vec3& along) const;
  bool next_on_line(std::uint32_t& t, std::size_t& corner, const Vec3& begin, const Vec3& along) const;

  const MeshModel& mesh_;
  const double slack_;
  std::map<std::uint32_t, std::size_t> face_of_;
  std::vector<CoplanarRegion> faces_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Edge> edges_;
};

}  // namespace tandem
