// The overlap of two features in contact: a face clipped by another (Sutherland and Hodgman 1974), two parallel edges
// side by side.
#pragma once
#include "manifold/flat_feature.h"
#include "manifold/patch_point.h"

namespace tandem {

constexpr int max_clipped = 3 * max_corners;
/// Points of a patch: those of clipping, and the pair's deepest point.
constexpr int max_patch = max_clipped + 1;
/// The feature number of the pair's deepest point, where it is deeper than all points of the clipping.
constexpr std::uint32_t witness_point = 0xffffffffu;
/// In tolerance::alike: the most by which the depth of a leaning disc's deepest point may fall short of its patch's.
constexpr double lowest_point_lacks = 0.25;

/// The points of `incident` over `reference`, projected along `outward` (the contact normal, from the reference's
/// shape), with their depths along it: there the line leaves one shape and enters the other. Points beyond the margin
/// by at most `slack` count as at it, so that shapes that touch to rounding keep their whole patch.
int clip_faces(const FlatFeature& reference, const FlatFeature& incident, const Vec3& outward, bool of_b, double margin,
               double deepest, double slack, PatchPoint* points);

/// The same along a triangle's own normal; where it lies beside the face in that view nothing is clipped.
int clip_over_triangle(const FlatFeature& triangle, const FlatFeature& incident, double margin, double deepest,
                       double slack, PatchPoint* points);

/// The interval where two parallel edges run side by side. Each end has its own depth: an angle within `flush` opens a
/// wider gap than that of a near contact.
int overlap_edges(const FlatFeature& a, const FlatFeature& b, const LocalAnswer& answer, double margin, double size,
                  PatchPoint* points);

}  // namespace tandem
