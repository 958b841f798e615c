#pragma once
#include "shapes/mesh_model.h"
#include "shapes/shape_insides.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Triangles from which on a mesh's hull, which takes longer than its building (3 times of a million triangles, more of
/// larger ones), is asked for only where an answer needs it.
inline constexpr std::size_t triangles_without_hull = std::size_t{1} << 18;

/// Is the hull not asked for to be quicker? By the mesh alone, so that no answer depends on what was asked before.
inline bool does_without_hull(const MeshModel& mesh) {
  return mesh.bends || mesh.triangles.size() >= triangles_without_hull;
}

/// A box that holds the posed shape, at once: of a mesh that does without a hull that about its turned box, else the
/// smallest. The smallest box of a wide and flat mesh, many of whose corners are as high as any, takes milliseconds.
inline Bounds quick_bounds(const Shape& shape, const Pose& pose, const WorkLimit* limit) {
  if (shape.kind() != ShapeKind::mesh || !does_without_hull(mesh_of(shape))) return shape.bounds(pose, limit);
  const MeshModel& mesh = mesh_of(shape);
  const Vec3 middle = pose * mesh.centre, half = pose.rotation.cwiseAbs() * mesh.half;
  return {middle - half - Vec3::Constant(shape.rounding()), middle + half + Vec3::Constant(shape.rounding())};
}

}  // namespace tandem
