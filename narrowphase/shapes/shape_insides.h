#pragma once
#include <memory>

#include "shapes/hull.h"
#include "shapes/mesh_model.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// What was built of a shape; lives as long as a copy of the shape does.
struct detail::ShapeInsides {
  static bool has_hull(const Shape& shape) { return shape.hull_ != nullptr; }
  static const Hull& hull(const Shape& shape) { return *shape.hull_; }
  static const MeshModel& mesh(const Shape& shape) { return *shape.mesh_; }
  static Bounds core_bounds(const Shape& shape, const Pose& pose) { return shape.core_bounds(pose); }
  /// The mesh of a model that is not to change as long as a copy of the shape lives.
  static Shape shape(std::shared_ptr<const MeshModel> model);
};

/// Is it a convex or a triangle?
inline bool has_hull(const Shape& shape) { return detail::ShapeInsides::has_hull(shape); }
/// Of a convex or a triangle.
inline const Hull& hull_of(const Shape& shape) { return detail::ShapeInsides::hull(shape); }
/// Of a mesh or a triangle.
inline const MeshModel& mesh_of(const Shape& shape) { return detail::ShapeInsides::mesh(shape); }

/// The box of a shape without its rounding.
inline Bounds core_bounds(const Shape& shape, const Pose& pose) {
  return detail::ShapeInsides::core_bounds(shape, pose);
}

}  // namespace tandem
