#pragma once
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

}  // namespace tandem::reference
