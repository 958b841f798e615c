// Distances by formulas: a point and a simple shape, two segments.
#pragma once
#include "shapes/support.h"

namespace tandem {

/// The signed distance of a point to a shape, in the shape's frame.
struct PointDistance {
  double signed_distance;
  Vec3 nearest;  ///< on the surface
  Vec3 normal;   ///< unit, outward: for a point outside, the direction from the surface to it
};

/// `shape` is a sphere, box, capsule, cylinder, cone, half-space or triangle (without thickness: no point is inside).
PointDistance point_distance(const ConvexView& shape, const Vec3& p);

/// The closest points of two segments, centre +- half, and the normal from the first to the second, defined also where
/// they cross.
struct SegmentDistance {
  double distance;
  Vec3 point_a;
  Vec3 point_b;
  Vec3 normal;
};
SegmentDistance segment_distance(const Vec3& centre_a, const Vec3& half_a, const Vec3& centre_b, const Vec3& half_b);

}  // namespace tandem
