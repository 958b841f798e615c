#pragma once
#include "continuous/moving_polygon.h"
#include "tandem/narrowphase/vertex_impact.h"

namespace tandem {

/// When a moving polygon first holds the origin, or comes within the separation of it; not looked for after `until`, in
/// [0, 1]: no `hit` says that there is none up to then.
template <std::size_t N>
VertexImpact search_impact(const MovingPolygon<N>& polygon, const ImpactOptions& options, double until);

}  // namespace tandem
