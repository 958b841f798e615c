#pragma once
#include "tandem/fcl/pair_queries.h"

namespace tandem::fcl {

/// FCL's own answers, for float compiled here: FCL's library has those for double alone.
std::size_t fcl_collide(const detail::GeometryPair<float>& pair, const ::fcl::CollisionRequest<float>& request,
                        ::fcl::CollisionResult<float>& result);
std::size_t fcl_collide(const detail::GeometryPair<double>& pair, const ::fcl::CollisionRequest<double>& request,
                        ::fcl::CollisionResult<double>& result);
float fcl_distance(const detail::GeometryPair<float>& pair, const ::fcl::DistanceRequest<float>& request,
                   ::fcl::DistanceResult<float>& result);
double fcl_distance(const detail::GeometryPair<double>& pair, const ::fcl::DistanceRequest<double>& request,
                    ::fcl::DistanceResult<double>& result);

}  // namespace tandem::fcl
