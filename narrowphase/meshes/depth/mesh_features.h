// The flat faces and straight edges of a mesh, whatever triangles they are cut into.
#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "meshes/traversal/coplanar_region.h"

namespace tandem {

/// Found as they are asked for; in the mesh's frame.
class MeshFeatures {
 public:
  /// `slack`: how far corners may lie from a plane or line, metres.
  MeshFeatures(const MeshModel& mesh, double slack) : mesh_(mesh), slack_(slack) {}

  /// The coplanar region about a triangle.
  const CoplanarRegion& face(std::uint32_t t);

  /// The straight line of edges that a triangle's edge k lies on.
  const Edge& straight_edge(std::uint32_t t, std::size_t k);

  /// Does the surface bend at edge k? Of the two triangles there the first says so.
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
