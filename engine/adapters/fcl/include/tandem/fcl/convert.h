// Conversion of FCL's geometries and transforms to shapes and poses.
#pragma once
#include <fcl/geometry/collision_geometry.h>

#include <memory>
#include <optional>
#include <unordered_map>

#include "tandem/narrowphase/shape.h"

namespace tandem::fcl {

/// Converts a geometry to a shape; S is float or double. Empty for geometries without a kind in tandem: octrees,
/// hierarchies over points without triangles, and user-defined classes. Meshes are surfaces, as FCL's are. Throws
/// std::invalid_argument for sizes that tandem::Shape refuses, such as a negative radius.
template <class S>
std::optional<Shape> to_shape(const ::fcl::CollisionGeometry<S>& geometry);
template <>
std::optional<Shape> to_shape(const ::fcl::CollisionGeometry<float>& geometry);
template <>
std::optional<Shape> to_shape(const ::fcl::CollisionGeometry<double>& geometry);

/// Converts a transform to a pose, with the rotation nearest to the given one. Throws std::invalid_argument if that is
/// not a rotation within 2e-6 (require_valid, tandem/narrowphase/pose.h): FCL accepts a scaling matrix, tandem does
/// not.
template <class S>
Pose to_pose(const ::fcl::Transform3<S>& transform) {
  const Pose pose{transform.linear().template cast<double>(), transform.translation().template cast<double>()};
  require_valid(pose, "fcl::Transform3");
  return orthonormalized(pose);
}

/// A cache of converted hulls and meshes, whose conversion is slow, for as long as their geometries live. The caller
/// holds one per thread. A geometry is identified by its address and a weak pointer, which shows whether it still
/// lives. If it is changed in place (BVHModel::beginReplaceModel), the caller must call forget.
class ShapeCache {
 public:
  /// The shape of a geometry, converted at first use; nullptr if to_shape has none. Valid while the geometry lives and
  /// is not forgotten.
  template <class S>
  const Shape* shape_of(const std::shared_ptr<const ::fcl::CollisionGeometry<S>>& geometry);
  void forget(const void* geometry) { kept_.erase(geometry); }
  void clear() { kept_.clear(); }
  std::size_t size() const { return kept_.size(); }

 private:
  struct Kept {
    std::weak_ptr<const void> geometry;
    std::optional<Shape> shape;
  };
  void drop_the_dead();

  std::unordered_map<const void*, Kept> kept_;
  std::size_t drop_at_ = 64;  // size at which expired ones are dropped next
};

template <class S>
const Shape* ShapeCache::shape_of(const std::shared_ptr<const ::fcl::CollisionGeometry<S>>& geometry) {
  const auto known = kept_.find(geometry.get());
  if (known != kept_.end() && !known->second.geometry.expired())
    return known->second.shape ? &*known->second.shape : nullptr;
  if (kept_.size() >= drop_at_) drop_the_dead();
  Kept& kept = kept_[geometry.get()] = {geometry, to_shape(*geometry)};
  return kept.shape ? &*kept.shape : nullptr;
}

}  // namespace tandem::fcl
