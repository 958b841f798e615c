// Where two features that lie on each other overlap: a face clipped by another (Sutherland and Hodgman 1974), two
// parallel edges side by side.
#pragma once
#include "manifold/flat_feature.h"
#include "manifold/patch_point.h"

namespace tandem {

constexpr int max_clipped = 3 * max_corners;
/// Points of a patch: what clipping leaves, and the pair's deepest.
constexpr int max_patch = max_clipped + 1;
/// The feature of the pair's deepest point where it is deeper than all that clipping found.
constexpr std::uint32_t witness_point = 0xffffffffu;
/// What a leaning disc's deepest point may lack to the greatest depth of its patch, in tolerance::alike.
constexpr double lowest_point_lacks = 0.25;

/// Points of `incident` over `reference`, seen along `outward` (the contact normal, from the reference's shape), by
/// depth along it: there the line leaves one shape and enters the other. Those beyond the margin by `slack` at most
/// count as at it: what touches to rounding has all of its patch.
int clip_faces(const FlatFeature& reference, const FlatFeature& incident, const Vec3& outward, bool of_b, double margin,
               double deepest, double slack, PatchPoint* points);

/// The stretch where two parallel edges lie side by side. Each end has its own depth: an angle within `flush` opens
/// by more than what nearly touches.
int overlap_edges(const FlatFeature& a, const FlatFeature& b, const LocalAnswer& answer, double margin, double size,
                  PatchPoint* points);

}  // namespace tandem
