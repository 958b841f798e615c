// The built data of a shape: hull and mesh model.
#pragma once
#include <memory>

#include "shapes/hull.h"
#include "shapes/lazily.h"
#include "shapes/mesh_model.h"
#include "shapes/voxel_model.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// The data that copies of a shape share.
struct detail::SharedParts {
  MadeOnce<MassProperties> mass;
};

namespace detail {

/// Shared data of shapes for which a hull or a mesh is built.
struct BuiltParts : SharedParts {
  BuiltParts(std::shared_ptr<const Hull> of_hull, std::shared_ptr<const MeshModel> of_mesh,
             std::shared_ptr<const VoxelModel> of_voxels = nullptr)
      : hull(std::move(of_hull)), mesh(std::move(of_mesh)), voxels(std::move(of_voxels)) {}

  std::shared_ptr<const Hull> hull;       ///< of a convex or triangle
  std::shared_ptr<const MeshModel> mesh;  ///< of a mesh or triangle
  std::shared_ptr<const VoxelModel> voxels;
};

}  // namespace detail

/// Access to the built data of a shape, which live as long as a copy of the shape.
struct detail::ShapeInsides {
  static bool has_hull(const Shape& shape) {
    return shape.kind_ == ShapeKind::convex || shape.kind_ == ShapeKind::triangle;
  }
  static bool has_mesh(const Shape& shape) {
    return shape.kind_ == ShapeKind::mesh || shape.kind_ == ShapeKind::triangle;
  }
  static bool is_built(const Shape& shape) {
    return has_hull(shape) || has_mesh(shape) || shape.kind_ == ShapeKind::voxels;
  }
  /// For a shape that is built.
  static const BuiltParts& parts(const Shape& shape) { return static_cast<const BuiltParts&>(*shape.parts_); }
  static const Hull& hull(const Shape& shape) { return *parts(shape).hull; }
  static const MeshModel& mesh(const Shape& shape) { return *parts(shape).mesh; }
  static const VoxelModel& voxels(const Shape& shape) { return *parts(shape).voxels; }
  static const void* address_of_parts(const Shape& shape) { return shape.parts_.get(); }  ///< null if it has none
  static std::size_t memory_of_parts(const Shape& shape);  ///< bytes, without what was built
  static Bounds core_bounds(const Shape& shape, const Pose& pose, const WorkLimit* limit) {
    return shape.core_bounds(pose, limit);
  }
  /// The shape of a model that must not change while a copy of the shape lives.
  static Shape shape(std::shared_ptr<const MeshModel> model);
};

/// True for a convex or a triangle.
inline bool has_hull(const Shape& shape) { return detail::ShapeInsides::has_hull(shape); }
/// True for a mesh or a triangle.
inline bool has_mesh(const Shape& shape) { return detail::ShapeInsides::has_mesh(shape); }
/// The hull of a convex or a triangle.
inline const Hull& hull_of(const Shape& shape) { return detail::ShapeInsides::hull(shape); }
/// The model of a mesh or a triangle.
inline const MeshModel& mesh_of(const Shape& shape) { return detail::ShapeInsides::mesh(shape); }
inline const VoxelModel& voxels_of(const Shape& shape) { return detail::ShapeInsides::voxels(shape); }

/// The box of a shape without its rounding.
inline Bounds core_bounds(const Shape& shape, const Pose& pose, const WorkLimit* limit) {
  return detail::ShapeInsides::core_bounds(shape, pose, limit);
}

}  // namespace tandem
