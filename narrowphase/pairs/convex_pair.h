// Two convex shapes: the policy that chooses the method.
#pragma once
#include <vector>

#include "shapes/convex_view.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// Answers convex (or half-space) against convex: by closed forms, separating axes, GJK and others, as the solver table
/// says. At least one of the two is bounded. Appends to `contacts` only for Request::contacts.
PairAnswer solve_convex(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b,
                        Request request, const NarrowPhaseOptions& options, std::vector<Contact>* contacts,
                        WarmStart* warm = nullptr);

}  // namespace tandem
