// Collision and distance queries of a pair with FCL's interface.
#pragma once
#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/collision_request.h>
#include <fcl/narrowphase/collision_result.h>
#include <fcl/narrowphase/distance_request.h>
#include <fcl/narrowphase/distance_result.h>

#include "tandem/fcl/convert.h"

namespace tandem::fcl {
namespace detail {

/// Two posed geometries, and their shapes: nullptr for one that tandem does not have.
template <class S>
struct GeometryPair {
  const ::fcl::CollisionGeometry<S>* o1;
  const ::fcl::Transform3<S>& tf1;
  const ::fcl::CollisionGeometry<S>* o2;
  const ::fcl::Transform3<S>& tf2;
  const Shape* a;
  const Shape* b;
};

std::size_t collide_pair(const GeometryPair<float>& pair, const ::fcl::CollisionRequest<float>& request,
                         ::fcl::CollisionResult<float>& result);
std::size_t collide_pair(const GeometryPair<double>& pair, const ::fcl::CollisionRequest<double>& request,
                         ::fcl::CollisionResult<double>& result);
float distance_pair(const GeometryPair<float>& pair, const ::fcl::DistanceRequest<float>& request,
                    ::fcl::DistanceResult<float>& result);
double distance_pair(const GeometryPair<double>& pair, const ::fcl::DistanceRequest<double>& request,
                     ::fcl::DistanceResult<double>& result);

/// A geometry's shape during a query: the cache's for hulls and meshes, a temporary one for all others, which are made
/// as fast as they would be found.
template <class S>
class ShapeOf {
 public:
  explicit ShapeOf(const ::fcl::CollisionGeometry<S>* geometry) : own_(to_shape(*geometry)) {}
  ShapeOf(const ::fcl::CollisionObject<S>* object, ShapeCache* cache) {
    const ::fcl::NODE_TYPE type = object->getNodeType();
    if (cache != nullptr && (type < ::fcl::GEOM_BOX || type == ::fcl::GEOM_CONVEX))
      kept_ = cache->shape_of(object->collisionGeometry());
    else
      own_ = to_shape(*object->collisionGeometry());
  }
  const Shape* get() const { return own_ ? &*own_ : kept_; }

 private:
  std::optional<Shape> own_;
  const Shape* kept_ = nullptr;
};

}  // namespace detail

/// ::fcl::collide, computed by tandem::NarrowPhase; S is float or double. As in FCL: contacts are added to those in
/// `result` up to request.num_max_contacts, keeping the deepest ones; normals point from o1 to o2, positions
/// lie midway between the surfaces, depths are >= 0. Without enable_contact a colliding pair adds one contact with only
/// o1 and o2, and two meshes one for each intersecting pair of triangles, with b1 and b2, if more than one is
/// requested. Geometries that are not occupied touch nothing. Returns the number of contacts in `result`. Differences:
/// - o1 and o2 of a contact are the arguments in their order, also where o2 alone is a mesh.
/// - A pair of convex shapes has up to four contacts, of two meshes up to four for each patch; b1 and b2 are NONE.
/// - gjk_solver_type, gjk_tolerance and the cached guess have no counterpart: answers are right to rounding.
/// - num_max_contacts = 0 returns 0 without a warning.
/// Geometries without a kind in tandem (to_shape), and requests with enable_cost, are passed on to ::fcl::collide.
///
/// Without `shapes`, a cache, hulls and meshes are converted at each call, which is slow.
template <class S>
std::size_t collide(const ::fcl::CollisionObject<S>* o1, const ::fcl::CollisionObject<S>* o2,
                    const ::fcl::CollisionRequest<S>& request, ::fcl::CollisionResult<S>& result,
                    ShapeCache* shapes = nullptr) {
  const detail::ShapeOf<S> a(o1, shapes), b(o2, shapes);
  return detail::collide_pair(
      detail::GeometryPair<S>{o1->collisionGeometry().get(), o1->getTransform(), o2->collisionGeometry().get(),
                              o2->getTransform(), a.get(), b.get()},
      request, result);
}
template <class S>
std::size_t collide(const ::fcl::CollisionGeometry<S>* o1, const ::fcl::Transform3<S>& tf1,
                    const ::fcl::CollisionGeometry<S>* o2, const ::fcl::Transform3<S>& tf2,
                    const ::fcl::CollisionRequest<S>& request, ::fcl::CollisionResult<S>& result) {
  const detail::ShapeOf<S> a(o1), b(o2);
  return detail::collide_pair(detail::GeometryPair<S>{o1, tf1, o2, tf2, a.get(), b.get()}, request, result);
}

/// ::fcl::distance, answered by tandem::NarrowPhase; S is float or double. As there: a distance below
/// result.min_distance replaces it, with o1 and o2 and, with enable_nearest_points, the nearest points, in the world;
/// nothing is done where it is 0 or less already; a pair that overlaps has -1, or minus its depth with
/// enable_signed_distance. Other than there:
/// - What is returned is result.min_distance, also of meshes that overlap.
/// - All kinds of pairs have a distance and, with enable_signed_distance, points on the surfaces; b1 and b2 are NONE.
/// - rel_err, abs_err, distance_tolerance and gjk_solver_type have no counterpart: answers are right to rounding.
/// Geometries without a kind in tandem (to_shape) are passed on to ::fcl::distance. `shapes` as above.
template <class S>
S distance(const ::fcl::CollisionObject<S>* o1, const ::fcl::CollisionObject<S>* o2,
           const ::fcl::DistanceRequest<S>& request, ::fcl::DistanceResult<S>& result, ShapeCache* shapes = nullptr) {
  const detail::ShapeOf<S> a(o1, shapes), b(o2, shapes);
  return detail::distance_pair(
      detail::GeometryPair<S>{o1->collisionGeometry().get(), o1->getTransform(), o2->collisionGeometry().get(),
                              o2->getTransform(), a.get(), b.get()},
      request, result);
}
template <class S>
S distance(const ::fcl::CollisionGeometry<S>* o1, const ::fcl::Transform3<S>& tf1,
           const ::fcl::CollisionGeometry<S>* o2, const ::fcl::Transform3<S>& tf2,
           const ::fcl::DistanceRequest<S>& request, ::fcl::DistanceResult<S>& result) {
  const detail::ShapeOf<S> a(o1), b(o2);
  return detail::distance_pair(detail::GeometryPair<S>{o1, tf1, o2, tf2, a.get(), b.get()}, request, result);
}

}  // namespace tandem::fcl
