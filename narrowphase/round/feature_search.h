// The nearest points of two bodies by their features: corners, edges, sides, circles and faces.
#pragma once
#include "round/support_descent.h"

namespace tandem {

/// Are both a box, the core of a capsule, a cylinder, a cone or a hull with a volume?
bool have_features(const ConvexView& a, const ConvexView& b);

/// The minimum of h that a descent from between the centres would find, for two of these, in a tenth of its time: a
/// point is carried to and fro between the bodies, one of which is moved away where they overlap or nearly do. That
/// soon shows which corners, edges, sides, circles and faces meet; for each two of these there is a closed form, or
/// Newton's method in an angle or two, and where that leads beyond the end of a feature the point goes on from there.
/// `optimal` where the supports along n and the two points bear it out, to
/// rounding: of bodies that are apart that is a proof. Else n is only a good direction, and the rest is not set. Ends
/// as soon as h < below.
/// `common` asks for a verdict only: set where a point of one that was found lies within the other; what is
/// returned then says nothing.
Support search_features(const MinkowskiDifference& d, double below, bool* common = nullptr);

}  // namespace tandem
