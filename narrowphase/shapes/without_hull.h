// Large meshes, whose hull is built only if an answer needs it.
#pragma once
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Number of triangles from which on a mesh's hull, which takes longer to build than the hierarchy (3 times for a
/// million triangles, more for larger ones), is built only if an answer needs it.
inline constexpr std::size_t triangles_without_hull = std::size_t{1} << 18;

/// True if the hull is not built to save time. Depends on the mesh alone, so that no answer depends on earlier queries.
inline bool does_without_hull(const MeshModel& mesh) {
  return mesh.bends || mesh.triangles.size() >= triangles_without_hull;
}

/// A box that contains the posed shape, without delay: for voxels and a mesh without a hull the box about the rotated
/// box, else the smallest. The smallest box of a wide and flat mesh, many of whose vertices are equally high, takes
/// milliseconds.
inline Bounds quick_bounds(const Shape& shape, const Pose& pose, const WorkLimit* limit) {
  if (shape.kind() == ShapeKind::voxels) {
    const auto [mid, half_box] = voxels_of(shape).box(voxels_of(shape).root());
    const Vec3 at = pose * mid, reach = pose.rotation.cwiseAbs() * half_box + Vec3::Constant(shape.rounding());
    return {at - reach, at + reach};
  }
  if (shape.kind() != ShapeKind::mesh || !does_without_hull(mesh_of(shape))) return shape.bounds(pose, limit);
  const MeshModel& mesh = mesh_of(shape);
  const Vec3 middle = pose * mesh.centre, half = pose.rotation.cwiseAbs() * mesh.half;
  return {middle - half - Vec3::Constant(shape.rounding()), middle + half + Vec3::Constant(shape.rounding())};
}

}  // namespace tandem
