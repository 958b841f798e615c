#pragma once
#include <cstdint>

#include "shapes/convex_view.h"

namespace tandem {

/// What of a core's surface is nearest to a point.
enum class Surface : std::uint8_t {
  none,      ///< the point is in the core, or of the core only its middle or one point towards it is known
  corner,    ///< also the end of a segment, the apex of a cone
  flat,      ///< a face of a box, a disc
  straight,  ///< an edge of a box, the side of a cylinder, the inside of a segment
  side,      ///< of a cone
  circle,
};

struct Projection {
  bool inside = false;  ///< a ball of the radius asked for about the point is in the core
  Surface surface = Surface::none;
};

/// Moves p to a point of the core near it, in its frame: the nearest, of an ellipsoid one towards its middle, of
/// hulls and triangles the middle. Where a ball of radius `least` about p is in the core, p stays.
Projection move_into(const ConvexView& core, Vec3& p, double least);

}  // namespace tandem
