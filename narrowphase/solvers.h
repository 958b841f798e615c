#pragma once
#include <vector>

#include "convex_view.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// Convex (or half-space) against convex: closed forms, SAT, GJK and the rest, by the dispatcher's table.
/// At least one of the two is bounded. Appends to `contacts` only for Request::contacts.
PairAnswer solve_convex(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b,
                        Request request, const NarrowPhaseOptions& options, std::vector<Contact>* contacts,
                        WarmStart* warm = nullptr);

/// A mesh against anything (either or both may be the mesh; never two half-spaces).
PairAnswer solve_mesh(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      const NarrowPhaseOptions& options, std::vector<Contact>* contacts);

/// Up to this distance (metres, of either sign) rounding may decide what a solver takes for a touch: then the verdict
/// of Request::collide is that of all requests. Relative to the sizes and the translation between them, some 500
/// epsilon: the solvers are right to a tenth of it.
inline double undecided_distance(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b) {
  constexpr double decided_by_rounding = 1e-13;
  return decided_by_rounding * (a.size() + b.size() + (pose_b.translation - pose_a.translation).lpNorm<1>());
}

/// The answer and the contacts from `first` on, with A and B exchanged.
void swap_answer(PairAnswer& answer, std::vector<Contact>* contacts, std::size_t first);

}  // namespace tandem
