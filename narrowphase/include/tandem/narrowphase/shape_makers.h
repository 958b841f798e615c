#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Balls of one radius (metres, >= 0) about points (one or more, finite) as one shape with a hierarchy: what a laser or
/// a depth camera sees. A mesh whose triangles are points, with rounding: Shape::triangles names the points.
Shape point_cloud(std::span<const Vec3> points, double radius);

/// Land: the solid between `bottom` (metres) and a surface of rows x columns heights (each >= 2, row by row, metres,
/// above the bottom). The corner of column i and row j is at x = i * spacing, y = j * spacing (metres, > 0), moved so
/// that the middle of all is at x = y = 0; each cell is two triangles, cut from its corner of least x and y.
Shape height_field(std::span<const double> heights, std::size_t columns, std::size_t rows, double spacing,
                   double bottom);

/// The union of cubes of a grid: cell (i, j, k) is the cube from (i, j, k) * size to (i + 1, j + 1, k + 1) * size, size
/// in metres, > 0. One cell or more, from -2^20 to 2^20 - 2 on each axis, in any order; one named twice is there once.
/// A solid mesh of the faces between a cell and a place without one: what is within is touched, and a depth is that of
/// the union, not of a cell. Shape::triangles come by axis of the face, then by cell.
Shape voxels(std::span<const std::array<std::int32_t, 3>> cells, double size);

}  // namespace tandem
