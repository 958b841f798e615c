// Minima of h where the supports of both bodies are smooth.
#pragma once
#include "round/minima.h"

namespace tandem {

/// Minima on a circle of each body.
void search_circles(Minima& m);

/// Minima for two ellipsoids, or one and a ball: descends from grid directions from which Newton's step does not lead
/// to a known minimum.
void search_ellipsoids(Minima& m);

}  // namespace tandem
