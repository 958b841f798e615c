// The triangles on which a contact or two witness points lie, by a query of each mesh with a point.
#include "tandem/narrowphase/triangles_at.h"

#include "meshes/traversal/point_queries.h"
#include "shapes/shape_insides.h"

namespace tandem {

std::uint32_t triangle_at(const Shape& shape, const Pose& pose, const Vec3& place, const Vec3& outward) {
  if (shape.kind() != ShapeKind::mesh) return 0;
  return nearest_triangle(mesh_of(shape), pose.rotation.transpose() * (place - pose.translation),
                          pose.rotation.transpose() * outward);
}

std::array<std::uint32_t, 2> triangles_at(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                          const Contact& contact) {
  const Vec3 half = contact.depth / 2 * contact.normal;
  return {triangle_at(a, pose_a, contact.point + half, contact.normal),
          triangle_at(b, pose_b, contact.point - half, -contact.normal)};
}

std::array<std::uint32_t, 2> triangles_at(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                          const PairAnswer& answer) {
  return {triangle_at(a, pose_a, answer.point_a, answer.normal),
          triangle_at(b, pose_b, answer.point_b, -answer.normal)};
}

}  // namespace tandem
