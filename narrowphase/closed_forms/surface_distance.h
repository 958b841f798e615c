// A point and a bounded convex shape of any kind: on which side of the surface it is, where the nearest point of that
// is, and how far the surface is along a direction.
#pragma once
#include <optional>

#include "shapes/convex_view.h"

namespace tandem {

/// Where a point is.
struct SurfaceDistance {
  bool inside;      ///< of the surface, by more than the slack that was asked for
  Vec3 normal;      ///< unit, outward at the nearest point of the surface; of a hull, from outside, that of some face
                    ///< between
  double distance;  ///< metres along it: negative inside
};

/// Of a point in the shape's frame; empty for spheres, half-spaces and meshes, and for hulls that are flat or have more
/// than 128 faces. `slack`: metres.
std::optional<SurfaceDistance> surface_distance(const ConvexView& shape, const Vec3& p, double slack);

/// The unit normal where the surface of an ellipsoid about the origin is nearest to a point inside or outside.
Vec3 ellipsoid_normal(const Vec3& radii, const Vec3& p);

/// How far it is from a point inside along d (unit) to the surface, metres: a lower bound to rounding; 0 of hulls that
/// are flat. Not of half-spaces and meshes.
double exit_length(const ConvexView& shape, const Vec3& p, const Vec3& d);

/// Ways out of a shape from a point inside.
struct WaysOut {
  Vec3 normal;      ///< unit, outward, at a point of the surface
  double distance;  ///< metres to the plane through that point square to it: no less than the least way out
  double exit;      ///< metres along a direction that was asked for, as exit_length
};

/// Of a point that is inside by more than `slack` (metres), along d (unit): what takes no iterations, so that of an
/// ellipsoid the normal is not that of the nearest point. Empty for other points, and where surface_distance is.
/// Of spheres, too.
std::optional<WaysOut> ways_out(const ConvexView& shape, const Vec3& p, const Vec3& d, double slack);

}  // namespace tandem
