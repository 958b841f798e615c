#pragma once
#include "shapes/minkowski_difference.h"

namespace tandem {

/// How far apart two cores are along the unit vector n (from A to B): never more than their signed distance, and as
/// much along the right n.
double separation_along(const MinkowskiDifference& d, const Vec3& n);

/// Two polytopes that almost touch, or are almost parallel there: the direction between nearest points is then a
/// difference of nearly equal numbers, and a face that is almost square to it comes out wrong by the noise times its
/// length. Tries the directions that faces, edges and corners near the answer's normal define, each from the lengths
/// of edges, and takes the one along which the cores are farthest apart. Sets normal, signed distance (of the cores)
/// and points; `gap` is how much more the distance claimed was. False, and nothing changed,
/// where no direction is better and the claim is met.
bool settle_by_features(const MinkowskiDifference& d, LocalAnswer& answer);

}  // namespace tandem
