// The depth of two bodies of which one is round: the least of the minima of h.
#pragma once
#include "round/support_descent.h"

namespace tandem {

/// The least of all local minima of h, with a bound on the uncertainty: h is nowhere below depth.h - gap.
struct Depth {
  Support best;
  double gap = 0;
};

/// Starts at a local minimum h >= 0, if `descended`, else at any direction. An expanding polytope within A - B (van den
/// Bergen 2001) bounds h from below and shows where it may be less; a descent from there decides. Ends with best.h < 0
/// if the two turn out to be separated.
Depth least_depth(const RoundPair& pair, const Support& start, bool descended);

}  // namespace tandem
