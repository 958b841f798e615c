#pragma once
#include <span>
#include <vector>

#include "boxes/box_box.h"
#include "closed_forms/closed_forms.h"
#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/options.h"

namespace tandem {

/// Pairs that cost less than preparing them for a general solver: straight from the shapes to the answer, and only
/// what is asked for. Null where a pair of kinds has none. Both convex, at most one a half-space. Arguments are those
/// of NarrowPhase::solve in its order, so that it hands on what it got as it stands.
using SimpleSolver = PairAnswer (*)(const NarrowPhaseOptions& options, const Shape& a, const Pose& pose_a,
                                    const Shape& b, const Pose& pose_b, Request request,
                                    std::vector<Contact>* contacts);
extern const std::array<std::array<SimpleSolver, shape_kinds>, shape_kinds> simple_solvers;  ///< by the two kinds

/// The same by parameters.
PairAnswer solve_spheres(double radius_a, const Vec3& a, double radius_b, const Vec3& b, Request request, double margin,
                         std::vector<Contact>* contacts);
PairAnswer solve_sphere_box(double radius, const Vec3& centre, const std::array<double, 4>& half, const Pose& pose,
                            Request request, double margin, std::vector<Contact>* contacts);
PairAnswer solve_sphere_capsule(double radius, const Vec3& centre, double capsule_radius, double length,
                                const Pose& pose, Request request, double margin, std::vector<Contact>* contacts);
PairAnswer solve_capsules(double radius_a, double length_a, const Pose& pose_a, double radius_b, double length_b,
                          const Pose& pose_b, Request request, double margin, std::vector<Contact>* contacts);
PairAnswer solve_box_capsule(const std::array<double, 4>& half, const Pose& pose_a, double radius, double length,
                             const Pose& pose_b, Request request, double margin, std::vector<Contact>* contacts);
PairAnswer solve_boxes(const std::array<double, 4>& half_a, const Pose& pose_a, const std::array<double, 4>& half_b,
                       const Pose& pose_b, Request request, double margin, std::vector<Contact>* contacts);

/// The manifold and what else is asked of two boxes whose overlap is known, in their order; no farther apart than the
/// margin.
void append_boxes(const HalfSize& half_a, const Pose& pose_a, const HalfSize& half_b, const Pose& pose_b,
                  const BoxAnswer& answer, double margin, std::vector<Contact>& contacts, PairAnswer& r);
/// The answer for two that touch, by their contacts along one normal: points halfway to either side of the deepest.
void answer_by_deepest(std::span<const Contact> contacts, double signed_distance, PairAnswer& r);

}  // namespace tandem
