// Continuous collision queries with FCL's interface.
#pragma once
#include <fcl/narrowphase/continuous_collision_request.h>
#include <fcl/narrowphase/continuous_collision_result.h>

#include "tandem/fcl/pair_queries.h"

namespace tandem::fcl {
namespace detail {

/// Two geometries, with their poses at the start (GeometryPair) and at the end.
template <class S>
struct MovingPair {
  GeometryPair<S> start;
  const ::fcl::Transform3<S>& end1;
  const ::fcl::Transform3<S>& end2;
};

float continuous_pair(const MovingPair<float>& pair, const ::fcl::ContinuousCollisionRequest<float>& request,
                      ::fcl::ContinuousCollisionResult<float>& result);
double continuous_pair(const MovingPair<double>& pair, const ::fcl::ContinuousCollisionRequest<double>& request,
                       ::fcl::ContinuousCollisionResult<double>& result);

}  // namespace detail

/// ::fcl::continuousCollide between two poses of each object, computed by NarrowPhase::time_of_impact; S is float or
/// double. As in FCL: request.ccd_motion_type selects the motion (CCDM_TRANS: straight, with the initial rotation;
/// CCDM_LINEAR: the origin on a straight line with uniform rotation; CCDM_SCREW); the result has is_collide,
/// time_of_contact in [0, 1] and both poses at that time; the time is returned. Differences:
/// - A contact is never missed, however short, and never reported later than by rounding (of S); it is reported early
///   where the objects come as near as 1e-10 of their path. num_max_iterations, toc_err and both solver types have no
///   counterpart.
/// - Without a contact the time is 1, and contact_tf1 and contact_tf2 are the end poses.
/// - Geometries that are not occupied touch nothing.
/// CCDM_SPLINE and geometries without a kind in tandem (to_shape) are passed on to ::fcl::continuousCollide, which
/// samples; for float they are refused, as FCL has no such function. Throws std::invalid_argument in that case, and for
/// a transform that is not a rotation and translation. `shapes` as for ::tandem::fcl::collide.
template <class S>
S continuousCollide(const ::fcl::CollisionObject<S>* o1, const ::fcl::Transform3<S>& tf1_end,
                    const ::fcl::CollisionObject<S>* o2, const ::fcl::Transform3<S>& tf2_end,
                    const ::fcl::ContinuousCollisionRequest<S>& request, ::fcl::ContinuousCollisionResult<S>& result,
                    ShapeCache* shapes = nullptr) {
  const detail::ShapeOf<S> a(o1, shapes), b(o2, shapes);
  return detail::continuous_pair(
      detail::MovingPair<S>{{o1->collisionGeometry().get(), o1->getTransform(), o2->collisionGeometry().get(),
                             o2->getTransform(), a.get(), b.get()},
                            tf1_end,
                            tf2_end},
      request, result);
}
template <class S>
S continuousCollide(const ::fcl::CollisionGeometry<S>* o1, const ::fcl::Transform3<S>& tf1_beg,
                    const ::fcl::Transform3<S>& tf1_end, const ::fcl::CollisionGeometry<S>* o2,
                    const ::fcl::Transform3<S>& tf2_beg, const ::fcl::Transform3<S>& tf2_end,
                    const ::fcl::ContinuousCollisionRequest<S>& request, ::fcl::ContinuousCollisionResult<S>& result) {
  const detail::ShapeOf<S> a(o1), b(o2);
  return detail::continuous_pair(detail::MovingPair<S>{{o1, tf1_beg, o2, tf2_beg, a.get(), b.get()}, tf1_end, tf2_end},
                                 request, result);
}

}  // namespace tandem::fcl
