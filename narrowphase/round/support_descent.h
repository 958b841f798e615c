// The minima of h, the support function of A - B: by Newton's method, and by convex problems.
#pragma once
#include "round/body_pair.h"

namespace tandem {

/// The distance of the points' sum from h n, metres: 0 at a minimum.
double residual(const Support& s);

/// The uncertainty that h and the points, which are on the two bodies, leave (metres): separated, the distance is at
/// most that of the points and at least -h; overlapping, n may still turn towards the points.
double doubt(const Support& s);

/// Descends on h over the unit sphere from direction n, by Newton steps within a cell of the sphere, where each body
/// has one smooth piece, and along the circles that divide the cells. Ends at a local minimum, which is minus the
/// distance where h < 0 (Cameron and Culley 1986: the least translation; Newton with an active set), or as soon as h <
/// below. h is always the support of the bodies along n; if that and the two points do not confirm the result, settle()
/// continues.
Support minimize(const RoundPair& pair, const Vec3& n, double below);

/// Finds a minimum of h by a sequence of convex problems, slower, but certain to descend: A - B is moved away from the
/// origin against n, GJK finds the direction to its nearest point, and n becomes that, until it no longer changes. h
/// never increases (the concave part of h(n) - c |n| linearised at n: Yuille and Rangarajan 2003).
Support settle(const RoundPair& pair, const Vec3& n, double below);

}  // namespace tandem
