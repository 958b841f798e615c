// Minkowski portal refinement: do two convex shapes touch?
#pragma once
#include "shapes/minkowski_difference.h"

namespace tandem {

/// The result of a portal search of two convex shapes.
struct PortalResult {
  enum class Verdict : std::uint8_t { open, apart, overlapping } verdict = Verdict::open;
  Vec3 normal =
      Vec3::UnitX();  ///< apart: a separating direction; open: the portal's normal; from A to B in A's frame, not unit
};

/// Decides whether the shapes touch. A triangle of points of A - B is moved outwards along the ray from an interior
/// point through the origin, until it has passed the origin or a plane separates it from the origin (Minkowski portal
/// refinement: Snethen, XenoCollide, Game Programming Gems 7, 2008). Costs little more than a support query a step.
/// Verdicts are certain, rounding included; a pair so near to touching that it would take many steps or rounding could
/// decide is left open.
PortalResult search_portal(const MinkowskiDifference& d);

}  // namespace tandem
