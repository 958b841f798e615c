#pragma once
#include <vector>

#include "convex_view.h"
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// Convex (or half-space) against convex: closed forms, SAT, GJK and the rest, by the dispatcher's table.
/// At least one of the two is bounded. Appends to `contacts` only for Request::contacts.
PairAnswer solve_convex(const ConvexView& a, const Pose& pose_a, const ConvexView& b, const Pose& pose_b,
                        Request request, const NarrowPhaseOptions& options, std::vector<Contact>* contacts);

/// The same for two spheres, and the verdict alone for a sphere with a box: granular scenes are made of these.
PairAnswer solve_spheres(double radius_a, const Vec3& a, double radius_b, const Vec3& b, Request request,
                         const NarrowPhaseOptions& options, std::vector<Contact>* contacts);
bool sphere_box_collide(double radius, const Vec3& centre, const Vec3& half, const Pose& pose);

/// A mesh against anything (either or both may be the mesh; never two half-spaces).
PairAnswer solve_mesh(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                      const NarrowPhaseOptions& options, std::vector<Contact>* contacts);

/// The answer and the contacts from `first` on, with A and B exchanged.
void swap_answer(PairAnswer& answer, std::vector<Contact>* contacts, std::size_t first);

}  // namespace tandem
