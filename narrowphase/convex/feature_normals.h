// Separations along given directions, and the settling of normals near contact.
#pragma once
#include "shapes/minkowski_difference.h"

namespace tandem {

/// The separation of two cores along the unit vector n (from A to B): never more than their signed distance, and equal
/// to it along the right n.
double separation_along(const MinkowskiDifference& d, const Vec3& n);

/// Settles the normal of two polytopes that almost touch or are almost parallel, where the direction between nearest
/// points is a difference of nearly equal numbers and has a large error. Tries the directions that faces, edges and
/// corners near the answer's normal define, each computed from edge vectors, and takes the one of largest separation.
/// Sets normal, signed distance (of the cores) and points; `gap`: by how much the distance may be larger: up to what
/// was claimed, for a depth plus the claim's own gap. False, without any change, where no direction is better and the
/// claim is confirmed.
bool settle_by_features(const MinkowskiDifference& d, LocalAnswer& answer);

}  // namespace tandem
