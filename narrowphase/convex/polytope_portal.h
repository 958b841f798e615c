// Minkowski portal refinement for two polytopes.
#pragma once
#include "convex/portal.h"

namespace tandem {

/// The same result as `search_portal`, for two polytopes of which one has a volume, in less time: begins with corners
/// of the faces through which the line between two interior points leaves, and uses known corners before it searches
/// for new ones. Also open where a hull has no such corners. The same bits on every instruction set.
using PortalKernel = void (*)(const MinkowskiDifference& d, PortalResult& r);
PortalKernel portal_kernel();

/// A triangle of corners of A - B.
struct SurfaceFace {
  enum class End : std::uint8_t { open, apart, reached } end = End::open;
  Vec3 normal;               ///< outward, not unit; apart: a separating direction, from A to B
  MinkowskiPoint corner[3];  ///< apart: the first is the farthest along the normal
  Vec3 centre;               ///< a point inside A - B
  double ball;               ///< radius of a ball about it that is in A - B
};

/// Finds the face of A - B where the ray from an interior point through the origin leaves: `reached` where no corner
/// lies beyond the triangle's plane. Because of rounding the ray may miss the triangle. `apart`: separated by more than
/// `beyond`, found before. Open as above.
using SurfaceKernel = void (*)(const MinkowskiDifference& d, double beyond, SurfaceFace& face);
SurfaceKernel surface_kernel();

}  // namespace tandem
