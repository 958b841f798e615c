#pragma once
#include "tandem/narrowphase/pose.h"

namespace tandem {

/// The normal where the surface of an ellipsoid is nearest to a point inside it, in its own frame (Eberly, Distance
/// from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid, 2013); not of unit length.
Vec3 nearest_normal(const Vec3& radii, const Vec3& point);

}  // namespace tandem
