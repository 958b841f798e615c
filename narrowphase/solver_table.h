#pragma once
#include "convex_pair.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// The cheapest measured row for the (unordered) pair whose error is within the tolerance; null if there is none.
const SolverRow* cheapest_row(ShapeKind a, ShapeKind b, Request request, double tolerance);

/// The method a row names.
Method method_of(const SolverRow& row);

}  // namespace tandem
