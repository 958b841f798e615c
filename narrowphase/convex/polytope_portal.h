#pragma once
#include "convex/portal.h"

namespace tandem {

/// What `search_portal` tells, of two polytopes of which one has a volume, for less: begins with corners of the faces
/// through which the line between two inner points leaves them, and goes on with corners known before it asks for new
/// ones. Open also where a hull has none of these at hand. The same bits on every instruction set.
using PortalKernel = void (*)(const MinkowskiDifference& d, PortalResult& r);
PortalKernel portal_kernel();

/// A triangle of corners of A - B.
struct SurfaceFace {
  enum class End : std::uint8_t { open, apart, reached } end = End::open;
  Vec3 normal;               ///< outward, not unit; apart: a direction that says so, from A to B
  MinkowskiPoint corner[3];  ///< apart: the first is the farthest along the normal
  Vec3 centre;               ///< a point inside A - B
  double ball;               ///< of a ball about it that is in A - B
};

/// Where the ray from a point inside A - B through the origin leaves the difference: `reached` where no corner lies
/// beyond the triangle's plane. That the ray goes through it is not certain to rounding. `apart`: by more than
/// `beyond`, found before. Open as above.
using SurfaceKernel = void (*)(const MinkowskiDifference& d, double beyond, SurfaceFace& face);
SurfaceKernel surface_kernel();

}  // namespace tandem
