// Voxels and any other shape: the cells that may be near are solved as boxes, by the solver for a box and the other
// shape, and their answers are combined to that of the union.
#pragma once
#include <vector>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"
#include "tandem/narrowphase/shape.h"

namespace tandem {

inline bool has_voxels(const Shape& a, const Shape& b) {
  return a.kind() == ShapeKind::voxels || b.kind() == ShapeKind::voxels;
}

/// NarrowPhase::solve for two of which one or both are voxels, with rounding, margin and cut-off.
PairAnswer solve_voxels(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                        const NarrowPhaseOptions& options, std::vector<Contact>* contacts);

/// NarrowPhase::solve without a work limit of its own: WorkStopped is thrown (narrow_phase.cpp).
PairAnswer solve_pair(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      const NarrowPhaseOptions& options, std::vector<Contact>* contacts);

}  // namespace tandem
