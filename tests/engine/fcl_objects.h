// Random objects for the tests of the FCL adapter.
#pragma once
#include <fcl/broadphase/broadphase_collision_manager.h>

#include <random>

namespace tandem::test {

using Random = std::mt19937;

/// A number in [lo, hi), the same on every system.
inline double uniform(Random& random, double lo, double hi) {
  return lo + (hi - lo) * (static_cast<double>(random()) / 4294967296.0);
}

/// A point in the cube [lo, hi)^3.
inline ::fcl::Vector3d random_point(Random& random, double lo, double hi) {
  return {uniform(random, lo, hi), uniform(random, lo, hi), uniform(random, lo, hi)};
}

template <class S>
using Object = ::fcl::CollisionObject<S>;
template <class S>
using Manager = ::fcl::BroadPhaseCollisionManager<S>;

}  // namespace tandem::test
