// Two simple shapes by formulas and separating axes.
#pragma once
#include <array>
#include <span>
#include <vector>

#include "boxes/box_box.h"
#include "closed_forms/closed_forms.h"
#include "tandem/narrowphase/answer.h"

namespace tandem {

/// A shape's parameters, as in Shape and ConvexView.
using Parameters = std::array<double, 4>;

/// Pairs that cost less than preparing them for a general solver: straight from the shapes' parameters to the answer,
/// and only what is asked for. Two of one kind may stand in either order.
using DirectSolver = PairAnswer(const Parameters& a, const Pose& pose_a, const Parameters& b, const Pose& pose_b,
                                Request request, double margin, std::vector<Contact>* contacts);

DirectSolver solve_halfspace_sphere, solve_halfspace_box;
DirectSolver solve_spheres, solve_sphere_box, solve_sphere_capsule;
DirectSolver solve_boxes, solve_box_capsule;
DirectSolver solve_capsules;

/// The manifold and what else is asked of two boxes whose overlap is known, in their order; no farther apart than the
/// margin.
void append_boxes(const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b, const Pose& pose_b,
                  const BoxAnswer& answer, double margin, std::vector<Contact>& contacts, PairAnswer& r);
/// The answer for two that touch, by their contacts along one normal: points halfway to either side of the deepest.
void answer_by_deepest(std::span<const Contact> contacts, double signed_distance, PairAnswer& r);

}  // namespace tandem
