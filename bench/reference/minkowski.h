// Signed distances by the difference of two convex shapes, with certified bounds.
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
  /// The scale of rounding errors.
  Real scale() const { return a.reach() + b.reach(); }
};

/// Bounds of the origin's signed distance from A - B, and the unit direction (from A to B) that attains the lower one.
struct Interval {
  Real lower = 0;
  Real upper = 0;
  Vec normal{1, 0, 0};
  bool unique = true;  ///< no direction more than 1e-3 away comes within 1e-9 of the scale
};

/// The distance of an origin outside, by the simplex nearest to it (Gilbert, Johnson, Keerthi 1988), until the bounds
/// agree to `tolerance` (absolute). With the origin inside, or on the surface to rounding, upper is 0 and lower has no
/// meaning.
Interval outside_distance(const Difference& difference, Real tolerance);

/// The signed distance of an origin inside or on the surface, by an expanding inner polytope (van den Bergen 2001): its
/// nearest face bounds the depth from below, the support along that face's normal from above. Stops at `tolerance` or
/// `most_vertices`.
Interval inside_distance(const Difference& difference, Real tolerance, std::size_t most_vertices);

/// Bounds of the signed distance of overlapping round shapes that (nearly) share an axis, where every direction across
/// it is (nearly) as good: the depth of their profiles in the plane, plus or minus their deviation from the axis. The
/// normal is not set. Only with the origin inside; empty where the shapes have no axis or do not share it to a
/// thousandth.
std::optional<Interval> axial_bounds(const Difference& difference, Real tolerance);

}  // namespace tandem::reference
