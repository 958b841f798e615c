// How deep points lie in a solid mesh, and balls that lie in it.
#pragma once
#include <cstddef>
#include <vector>

#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// A place in a mesh: a ball of radius `depth` about it lies in the mesh.
struct DepthAt {
  double depth;  ///< metres; < 0: outside a solid, by so much. Never too large, by more than rounding
  Vec3 inward;   ///< unit, from the nearest point of the surface, into a solid; zero on it
};

/// The depth of points of a mesh where it is, which is a function that changes no faster than its point moves. Of a
/// mesh that is not solid no point lies deeper than 0, and those of the surface do.
class DepthField {
 public:
  /// `mesh` outlives this; `slack`: what places are rounded by, metres.
  DepthField(const Posed& mesh, double slack, const WorkLimit* limit);

  DepthAt at(const Vec3& place) const;

  const Bounds& box() const { return box_; }  ///< about the mesh
  const MeshModel& mesh() const { return mesh_; }
  Vec3 placed(const Vec3& v) const { return pose_.rotation * v + pose_.translation; }

 private:
  const MeshModel& mesh_;
  const Pose pose_;
  const Bounds box_;
  const Mat3 inverse_;
  const double slack_, least_stretch_;  ///< by how much the pose's rotation may shorten
  const WorkLimit* limit_;
};

struct Ball {
  Vec3 centre;
  double radius;
};

/// Balls in the mesh that touch its surface in places all over it, as large as they may be there: `most` at most (Ma,
/// Bae and Choi, 3D medial axis point approximation using nearest neighbors and the normal field, 2012). Of a mesh that
/// is not solid these places, with radius 0.
std::vector<Ball> inner_balls(const DepthField& field, std::size_t most);

}  // namespace tandem
