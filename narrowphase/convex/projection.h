// Points moved into convex cores.
#pragma once
#include <cstdint>

#include "shapes/convex_view.h"

namespace tandem {

/// The feature of a core's surface nearest to a point.
enum class Surface : std::uint8_t {
  none,      ///< the point is in the core, or only the core's centre or one point towards it was taken
  corner,    ///< also the end of a segment, the apex of a cone
  flat,      ///< a face of a box, a disc
  straight,  ///< an edge of a box, the lateral surface of a cylinder, the interior of a segment
  side,      ///< the lateral surface of a cone
  circle,
};

struct Projection {
  bool inside = false;  ///< a ball of the given radius about the point is in the core
  Surface surface = Surface::none;
};

/// Moves p to a point of the core near it, in the core's frame: the nearest one; for an ellipsoid a point towards its
/// centre; for hulls and triangles the centroid. If a ball of radius `least` about p is in the core, p stays.
Projection move_into(const ConvexView& core, Vec3& p, double least);

}  // namespace tandem
