// A point and a bounded convex shape of any kind: on which side of the surface it is, about which way leads there, and how
// far the surface is along a direction. The way is to choose a direction by, which then says what it says exactly.
#pragma once
#include <optional>

#include "shapes/convex_view.h"

namespace tandem {

/// Where a point is.
struct WayOut {
  bool inside;  ///< of the surface, by more than the slack that was asked for
  Vec3 normal;  ///< unit: from the surface to a point outside, towards it from a point inside, along the nearest way or so
};

/// Of a point in the shape's frame; empty for kinds without, and for hulls that are flat or have more than 128 faces.
/// `slack`: metres.
std::optional<WayOut> way_out(const ConvexView& shape, const Vec3& p, double slack);

/// How far it is from a point inside along d (unit) to the surface: a lower bound to rounding, of such a shape.
double exit_length(const ConvexView& shape, const Vec3& p, const Vec3& d);

}  // namespace tandem
