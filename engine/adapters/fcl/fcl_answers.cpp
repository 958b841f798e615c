// FCL's own queries of a pair, for geometries that tandem does not have.
#include "fcl_answers.h"

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/continuous_collision.h>
#include <fcl/narrowphase/distance.h>

#include <stdexcept>
#include <string>

namespace tandem::fcl {

std::size_t fcl_collide(const detail::GeometryPair<float>& pair, const ::fcl::CollisionRequest<float>& request,
                        ::fcl::CollisionResult<float>& result) {
  return ::fcl::collide(pair.o1, pair.tf1, pair.o2, pair.tf2, request, result);
}
std::size_t fcl_collide(const detail::GeometryPair<double>& pair, const ::fcl::CollisionRequest<double>& request,
                        ::fcl::CollisionResult<double>& result) {
  return ::fcl::collide(pair.o1, pair.tf1, pair.o2, pair.tf2, request, result);
}
float fcl_distance(const detail::GeometryPair<float>& pair, const ::fcl::DistanceRequest<float>& request,
                   ::fcl::DistanceResult<float>& result) {
  return ::fcl::distance(pair.o1, pair.tf1, pair.o2, pair.tf2, request, result);
}
double fcl_distance(const detail::GeometryPair<double>& pair, const ::fcl::DistanceRequest<double>& request,
                    ::fcl::DistanceResult<double>& result) {
  return ::fcl::distance(pair.o1, pair.tf1, pair.o2, pair.tf2, request, result);
}
float fcl_continuous(const detail::MovingPair<float>&, const ::fcl::ContinuousCollisionRequest<float>& request,
                     ::fcl::ContinuousCollisionResult<float>&) {
  throw std::invalid_argument("continuousCollide in float: ccd_motion_type is " +
                              std::to_string(request.ccd_motion_type) +
                              ", allowed: translations, linear and screw motions of geometries that to_shape takes");
}
double fcl_continuous(const detail::MovingPair<double>& pair, const ::fcl::ContinuousCollisionRequest<double>& request,
                      ::fcl::ContinuousCollisionResult<double>& result) {
  const auto& [o1, tf1, o2, tf2, a, b] = pair.start;
  return ::fcl::continuousCollide(o1, tf1, pair.end1, o2, tf2, pair.end2, request, result);
}

}  // namespace tandem::fcl
