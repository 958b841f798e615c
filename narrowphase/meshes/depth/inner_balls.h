// Depths of points in a solid mesh, and balls inscribed in it.
#pragma once
#include <cstddef>
#include <vector>

#include "shapes/posed_mesh.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// The depth of a point in a mesh: a ball of radius `depth` about it lies in the mesh.
struct DepthAt {
  double depth;  ///< metres; < 0: minus the distance outside a solid. Too large at most by rounding
  Vec3 inward;   ///< unit, from the nearest point of the surface into a solid; zero on it
};

/// The depth of points of a posed mesh, a function with Lipschitz constant 1. In a mesh that is not solid no point has
/// a depth above 0, and those of the surface have 0.
class DepthField {
 public:
  /// `mesh` must outlive this; `slack`: rounding of positions, metres.
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
  const double slack_, least_stretch_;  ///< factor by which the pose's rotation may shorten
  const WorkLimit* limit_;
};

struct Ball {
  Vec3 centre;
  double radius;
};

/// At most `most` inscribed balls that touch the surface at points all over it, each as large as possible there (Ma,
/// Bae and Choi, 3D medial axis point approximation using nearest neighbors and the normal field, 2012). For a mesh
/// that is not solid these points, with radius 0.
std::vector<Ball> inner_balls(const DepthField& field, std::size_t most);

}  // namespace tandem
