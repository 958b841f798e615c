#pragma once
#include "shapes/minkowski_difference.h"

namespace tandem {

/// What a portal tells of two convex shapes.
struct PortalResult {
  enum class Verdict : std::uint8_t { open, apart, overlapping } verdict = Verdict::open;
  Vec3 normal =
      Vec3::UnitX();  ///< apart: a direction that says so; open: of the portal; from A to B in A's frame, not unit
};

/// Do the shapes touch? A triangle of points of A - B is moved outwards along the ray from a point inside through the
/// origin, until it has passed the origin or a plane leaves the origin outside (Minkowski portal refinement: Snethen,
/// XenoCollide, Game Programming Gems 7, 2008). A support a step and little else. What it says is certain, rounding
/// included; what is so near to touching that it would take many steps or rounding could decide is left open.
PortalResult search_portal(const MinkowskiDifference& d);

}  // namespace tandem
