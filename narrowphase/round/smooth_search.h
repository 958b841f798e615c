// Minima of h where the supports of both bodies are smooth.
#pragma once
#include "round/minima.h"

namespace tandem {

/// On a circle of each.
void search_circles(Minima& m);

/// On two ellipsoids, or one and a ball: from wherever Newton's step is not seen to lead to a known one.
void search_ellipsoids(Minima& m);

}  // namespace tandem
