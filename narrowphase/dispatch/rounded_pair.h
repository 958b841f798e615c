// Pairs of which one or both shapes have rounding: the answer of their cores, adjusted by the radii.
#pragma once
#include <vector>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

/// NarrowPhase::solve as if neither shape had rounding (narrow_phase.cpp).
PairAnswer solve_cores(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                       const NarrowPhaseOptions& options, std::vector<Contact>* contacts, WarmStart* warm);

/// NarrowPhase::solve for two of which at least one has rounding.
///
/// Signed distance of two convex shapes, of which one grows by a ball of radius r, is less by r: the support function
/// of A - B grows by r along every direction. Of a mesh the same holds for what is apart; where it overlaps, a
/// translation that separates must leave a gap of r between the cores, which is tried, and no shorter one does than r
/// longer than the cores': a distance changes by no more than a translation's length.
PairAnswer solve_rounded(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                         const NarrowPhaseOptions& options, std::vector<Contact>* contacts, WarmStart* warm);

}  // namespace tandem
