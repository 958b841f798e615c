// FCL's own queries of a pair, for what tandem has no kind for.
#include "fcl_answers.h"

#include <fcl/narrowphase/collision.h>
#include <fcl/narrowphase/distance.h>

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

}  // namespace tandem::fcl
