// Cones of a mesh's normals, for every node of its hierarchy (Johnson and Cohen, Spatialized normal cone hierarchies,
// 2001): at the nearest points of two surfaces their normals oppose each other along the line between them.
#pragma once
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// All directions within an angle of an axis.
struct NormalCone {
  Eigen::Vector3f axis = Eigen::Vector3f::Zero();  ///< unit, in the mesh's frame
  float angle = 4;                                 ///< radians; pi and more: every direction
};

class NormalCones {
 public:
  /// `cones`: for the lanes of all nodes, `lanes` each.
  NormalCones(std::vector<NormalCone> cones, std::size_t lanes) : cones_(std::move(cones)), lanes_(lanes) {}

  /// The cone for a child of a node: contains the normals of all triangles below it and of all that share a corner with
  /// one of these, and so all directions along which their faces, edges and corners are farthest; all directions if one
  /// has a border or no area.
  const NormalCone& of(std::uint32_t node, std::uint32_t lane) const { return cones_[node * lanes_ + lane]; }
  std::size_t memory() const { return cones_.capacity() * sizeof(NormalCone); }

 private:
  std::vector<NormalCone> cones_;
  std::size_t lanes_;
};

}  // namespace tandem
