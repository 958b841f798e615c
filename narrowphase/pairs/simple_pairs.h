// Pairs of simple shapes by formulas and separating axes.
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

/// A solver for pairs that cost less than preparing them for a general solver: straight from the shapes' parameters to
/// the answer, computing only what is asked for. Two shapes of one kind may be in either order.
using DirectSolver = PairAnswer(const Parameters& a, const Pose& pose_a, const Parameters& b, const Pose& pose_b,
                                Request request, double margin, std::vector<Contact>* contacts);

DirectSolver solve_halfspace_sphere, solve_halfspace_box;
DirectSolver solve_spheres, solve_sphere_box, solve_sphere_capsule;
DirectSolver solve_boxes, solve_box_capsule;
DirectSolver solve_capsules;

/// Appends the manifold and completes the answer of two boxes, in their order, that are no farther apart than the
/// margin; their BoxAnswer is known.
void append_boxes(const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b, const Pose& pose_b,
                  const BoxAnswer& answer, double margin, std::vector<Contact>& contacts, PairAnswer& r);
/// The answer for two shapes that touch, by their contacts along one normal: points to either side of the deepest
/// contact.
void answer_by_deepest(std::span<const Contact> contacts, double signed_distance, PairAnswer& r);

}  // namespace tandem
