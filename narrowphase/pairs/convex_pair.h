#pragma once
#include <vector>

#include "shapes/convex_view.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// Convex (or half-space) against convex: closed forms, SAT, GJK and the rest, by the dispatcher's table.
/// At least one of the two is bounded. Appends to `contacts` only for Request::contacts.
PairAnswer solve_convex(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b,
                        Request request, const NarrowPhaseOptions& options, std::vector<Contact>* contacts,
                        WarmStart* warm = nullptr);

}  // namespace tandem
