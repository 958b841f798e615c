// The distance of a point from the surface of a bounded convex shape of any kind: on which side it is, the nearest
// surface point's normal, and the distance to the surface along a direction.
#pragma once
#include <cstddef>
#include <optional>

#include "shapes/convex_view.h"

namespace tandem {

/// Hulls of more faces are not asked for all of them in turn: solvers, which go from face to face, are faster.
inline constexpr std::size_t most_faces_in_turn = 128;

/// The position of a point relative to a surface.
struct SurfaceDistance {
  bool inside;      ///< below the surface by more than the given slack
  Vec3 normal;      ///< unit, outward at the nearest point of the surface; of a hull, from outside, that of some face
                    ///< between
  double distance;  ///< metres along the normal: negative inside; of a hull, from outside, a lower bound
};

/// For a point in the shape's frame; empty for spheres, half-spaces and meshes, and for hulls that are flat or have
/// more than `most_faces_in_turn`. `slack`: metres.
std::optional<SurfaceDistance> surface_distance(const ConvexView& shape, const Vec3& p, double slack);

/// The unit normal at the point of the surface of an ellipsoid about the origin nearest to a point inside or outside.
Vec3 ellipsoid_normal(const Vec3& radii, const Vec3& p);

/// The distance in metres from a point inside along d (unit) to the surface: a lower bound to rounding; 0 for flat
/// hulls. Not for half-spaces and meshes.
double exit_length(const ConvexView& shape, const Vec3& p, const Vec3& d);

}  // namespace tandem
