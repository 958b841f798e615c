// The depth of two bodies of which one is round: the least of the minima of h.
#pragma once
#include "round/support_descent.h"

namespace tandem {

/// The least of all local minima of h, and a bound on what is not known: h
/// reaches nowhere less than depth.h - gap.
struct Depth {
  Support best;
  double gap = 0;
};

/// From a local minimum h >= 0, where `descended`, else from any direction. An expanding polytope within A - B (van den
/// Bergen 2001) bounds h from below and shows where else it may be less; a descent
/// from there decides. Ends with best.h < 0 where the two turn out to be apart.
Depth least_depth(const RoundPair& pair, const Support& start, bool descended);

}  // namespace tandem
