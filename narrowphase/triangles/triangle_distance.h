#pragma once
#include <limits>
#include <optional>

#include "shapes/minkowski_difference.h"

namespace tandem {

/// Signed distance of a triangle (B) to a box or a triangle (A): by the axes that can separate them, their faces'
/// normals and the products of their edges, which have the least depth of two polytopes so small; apart past an edge or
/// corner, by the nearest of those. Ends early for shapes that are more than `beyond` apart: signed_distance is then a
/// separation along the normal, the points are not set. Empty where rounding leaves doubt (edges almost parallel) and
/// of triangles with next to no area.
std::optional<LocalAnswer> triangle_distance(const MinkowskiDifference& d,
                                             double beyond = std::numeric_limits<double>::infinity());

}  // namespace tandem
