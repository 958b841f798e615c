// The distance of a segment and a box, for capsules.
#pragma once
#include "boxes/box_axes.h"
#include "shapes/support.h"

namespace tandem {

/// The x in [-reach, reach] that brings middle + x along nearest to the box of half sizes `half` at the origin: the
/// distance is convex and piecewise quadratic in x. `along` is a unit vector, `start` in the interval.
double nearest_on_line(const Vec3& half, const Vec3& middle, const Vec3& along, double reach, double start);

/// Squared distance of a segment (centre +- reach x along, `along` a unit vector) from a box at the origin.
double segment_box_distance2(const HalfSize& half, const Vec3& centre, const Vec3& along, double reach);

/// The signed distance of a segment and a box: separated by line search, overlapping by the normals of their Minkowski
/// sum, which are the box's faces and the cross products of its edges and the segment. In the box's frame, normal from
/// the box to the segment.
LocalAnswer segment_box_distance(const HalfSize& half, const Vec3& centre, const Vec3& along, double reach);

}  // namespace tandem
