// The minima of h, how far A - B reaches along a direction: by Newton's method, and by convex problems.
#pragma once
#include "round/body_pair.h"

namespace tandem {

/// How far h and the points, which are of the two bodies, leave the answer open (metres): apart, the bodies are no
/// farther from each other than the points and no nearer than -h; in each other, n may still turn to where the points
/// are.
double doubt(const Support& s);

/// Goes downhill on h over the unit sphere from direction n, by Newton steps
/// within a cell of the sphere where each body has one smooth piece, and along
/// the circles where the cells meet. Ends at a local minimum, which is the
/// distance where h < 0 (Cameron and Culley 1986: the least translation; Newton
/// with an active set), or as soon as h < below. h is always what the bodies'
/// supports along n say; where that and the two points do not bear out what was
/// found, settle() goes on.
Support minimize(const RoundPair& pair, const Vec3& n, double below);

/// A minimum of h by a sequence of convex problems, slower, but certain to descend: A - B is moved away from the origin
/// against n, GJK finds the direction to its nearest point, and n turns there, until it turns no more. h never
/// increases (the concave part of h(n) - c |n| linearised at n: Yuille and Rangarajan 2003).
Support settle(const RoundPair& pair, const Vec3& n, double below);

}  // namespace tandem
