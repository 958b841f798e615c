// The signed distance of a triangle and a box or triangle.
#pragma once
#include <limits>
#include <optional>

#include "shapes/minkowski_difference.h"

namespace tandem {

/// Signed distance of a triangle (B) to a box or a triangle (A), by the axes that can separate them: face normals and
/// cross products of edges, among which is the normal of least depth of two such polytopes; separated diagonally, by
/// the nearest edges or corners. Ends early for shapes more than `beyond` apart: signed_distance is then a separation
/// along the normal, the points are not set. Empty where rounding leaves doubt (edges almost parallel) and for almost
/// degenerate triangles.
std::optional<LocalAnswer> triangle_distance(const MinkowskiDifference& d,
                                             double beyond = std::numeric_limits<double>::infinity());

}  // namespace tandem
