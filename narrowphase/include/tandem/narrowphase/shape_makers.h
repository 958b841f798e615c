#pragma once
#include <cstddef>
#include <span>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Balls of one radius (metres, >= 0) about points (one or more, finite) as one shape with a hierarchy: what a laser or a
/// depth camera sees. A mesh whose triangles are points, with rounding: Shape::triangles names the points.
Shape point_cloud(std::span<const Vec3> points, double radius);

/// Land: the solid between `bottom` (metres) and a surface of rows x columns heights (each >= 2, row by row, metres, above
/// the bottom). The corner of column i and row j is at x = i * spacing, y = j * spacing (metres, > 0), moved so that the
/// middle of all is at x = y = 0; each cell is two triangles, cut from its corner of least x and y.
Shape height_field(std::span<const double> heights, std::size_t columns, std::size_t rows, double spacing, double bottom);

}  // namespace tandem
