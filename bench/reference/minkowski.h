#pragma once
#include <optional>
#include <vector>

#include "posed_core.h"

namespace tandem::reference {

/// A - B of two cores.
struct Difference {
  const PosedCore& a;
  const PosedCore& b;

  Vec support(const Vec& d) const { return a.support(d) - b.support(-d); }
  /// Of all rounding errors.
  Real scale() const { return a.reach() + b.reach(); }
};

/// Bounds of the origin's signed distance from A - B, and the unit direction (from A to B) that attains the lower one.
struct Interval {
  Real lower = 0;
  Real upper = 0;
  Vec normal{1, 0, 0};
  bool unique = true;  ///< no other direction, by more than 1e-3, comes within 1e-9 of the scale
};

/// Distance from outside by the simplex nearest the origin (Gilbert, Johnson, Keerthi 1988), until the bounds meet to
/// `tolerance` (absolute). With the origin inside, or on the surface to rounding, upper is 0 and lower says nothing.
Interval outside_distance(const Difference& difference, Real tolerance);

/// Signed distance with the origin inside or on the surface, by an inner polytope that expands (van den Bergen 2001):
/// its nearest face bounds the depth from below, its support from above. Stops at `tolerance` or `most_vertices`.
Interval inside_distance(const Difference& difference, Real tolerance, std::size_t most_vertices);

/// Bounds of the signed distance where two round shapes (nearly) share an axis, and every direction across it is
/// (nearly) as good: their profiles' depth in the plane, give or take how far they are off the axis. The normal is not
/// set. Only with the origin inside; empty where the shapes have no axis or it is not shared to a thousandth.
std::optional<Interval> axial_bounds(const Difference& difference, Real tolerance);

}  // namespace tandem::reference
