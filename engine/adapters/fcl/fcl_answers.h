// FCL's own answers, for geometries that tandem does not have.
#pragma once
#include "tandem/fcl/continuous_queries.h"
#include "tandem/fcl/pair_queries.h"

namespace tandem::fcl {

/// FCL's own answers; for float they are compiled here, since FCL's library has them only for double.
std::size_t fcl_collide(const detail::GeometryPair<float>& pair, const ::fcl::CollisionRequest<float>& request,
                        ::fcl::CollisionResult<float>& result);
std::size_t fcl_collide(const detail::GeometryPair<double>& pair, const ::fcl::CollisionRequest<double>& request,
                        ::fcl::CollisionResult<double>& result);
float fcl_distance(const detail::GeometryPair<float>& pair, const ::fcl::DistanceRequest<float>& request,
                   ::fcl::DistanceResult<float>& result);
double fcl_distance(const detail::GeometryPair<double>& pair, const ::fcl::DistanceRequest<double>& request,
                    ::fcl::DistanceResult<double>& result);
/// FCL has none for float: its motions are then abstract classes. Throws std::invalid_argument.
float fcl_continuous(const detail::MovingPair<float>& pair, const ::fcl::ContinuousCollisionRequest<float>& request,
                     ::fcl::ContinuousCollisionResult<float>& result);
double fcl_continuous(const detail::MovingPair<double>& pair, const ::fcl::ContinuousCollisionRequest<double>& request,
                      ::fcl::ContinuousCollisionResult<double>& result);

}  // namespace tandem::fcl
