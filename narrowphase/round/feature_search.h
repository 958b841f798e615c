// The nearest points of two bodies by their features: corners, edges, lateral surfaces, circles and faces.
#pragma once
#include "round/support_descent.h"

namespace tandem {

/// True if both are a box, the core of a capsule, a cylinder, a cone or a hull with a volume.
bool have_features(const ConvexView& a, const ConvexView& b);

/// The minimum of h that a descent from the line of centres would find, for two of these kinds, in a tenth of its time.
/// A point is projected back and forth between the bodies, one of which is moved away if they overlap or nearly do.
/// That soon yields the nearest features; for each two of these there is a closed form, or Newton's method in one or
/// two angles, and where that leads beyond the end of a feature the point continues from there. `optimal` if the
/// supports along n and the two points confirm the result to rounding: for separated bodies that is a proof. Otherwise
/// n is only a good direction, and the rest is not set. Ends as soon as h < below. `common` requests only a verdict:
/// set if a point of one body that was found lies within the other; the returned value is then meaningless.
Support search_features(const MinkowskiDifference& d, double below, bool* common = nullptr);

}  // namespace tandem
