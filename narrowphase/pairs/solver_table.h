#pragma once
#include <span>

#include "pairs/methods.h"
#include "tandem/narrowphase/solver_info.h"

namespace tandem {

/// The measured rows: by pair of kinds and request, the cheapest first.
std::span<const SolverRow> solver_rows();

/// The cheapest measured row for the (unordered) pair whose error is within the tolerance; null if there is none.
const SolverRow* cheapest_row(ShapeKind a, ShapeKind b, Request request, double tolerance);

/// The method a row names.
Method method_of(const SolverRow& row);

}  // namespace tandem
