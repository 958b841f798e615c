// FCL's shapes and poses for ours.
#pragma once
#include <fcl/geometry/collision_geometry.h>

#include <memory>

#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

/// FCL's shape for ours, meshes as BVHModel<OBBRSS>. A triangle becomes a flat fcl::Convex: FCL's own triangle has no
/// queries.
std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const Shape& shape);

/// A mesh as BVHModel<RSS>, a hierarchy of rectangles swept by spheres, which is faster for distances.
std::shared_ptr<fcl::CollisionGeometryd> fcl_spheres_shape(const Shape& mesh);

/// The pose relative to `origin`: far from the world's origin FCL would lose digits.
inline fcl::Transform3d fcl_pose(const Pose& pose, const Vec3& origin = Vec3::Zero()) {
  fcl::Transform3d t = fcl::Transform3d::Identity();
  t.linear() = pose.rotation;
  t.translation() = pose.translation - origin;
  return t;
}

}  // namespace tandem::bench
