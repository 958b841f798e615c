// The first impact of two features whose vertices move on straight lines.
#pragma once
#include "continuous/moving_polygon.h"
#include "tandem/narrowphase/vertex_impact.h"

namespace tandem {

/// The time at which a moving polygon first contains the origin, or comes within the separation of it; searched up to
/// `until`, in [0, 1]: without a `hit` there is none up to then.
template <std::size_t N>
VertexImpact search_impact(const MovingPolygon<N>& polygon, const ImpactOptions& options, double until);

}  // namespace tandem
