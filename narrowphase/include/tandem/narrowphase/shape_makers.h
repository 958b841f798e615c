// Shapes of sensor data: point clouds, height fields, voxels.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Balls of one radius (metres, >= 0) about points (one or more, finite) as one shape with a hierarchy, as for data of
/// a laser or depth camera. A mesh whose triangles are points, with rounding: Shape::triangles gives the points.
Shape point_cloud(std::span<const Vec3> points, double radius);

/// Terrain: the solid between `bottom` (metres) and a surface of rows x columns heights (each >= 2, row by row, metres,
/// above the bottom). The vertex of column i and row j is at x = i * spacing, y = j * spacing (metres, > 0), shifted so
/// that the centre is at x = y = 0; each cell is two triangles, divided from its vertex of least x and y.
Shape height_field(std::span<const double> heights, std::size_t columns, std::size_t rows, double spacing,
                   double bottom);

/// Voxels of cells of one size: cell (i, j, k) is the cube from (i, j, k) * size to (i + 1, j + 1, k + 1) * size,
/// relative to `origin`; size in metres, > 0. One cell or more, from -2^20 to 2^20 - 1 on each axis, in any order;
/// duplicates count once.
Shape voxels(std::span<const std::array<std::int32_t, 3>> cells, double size, const Vec3& origin = Vec3::Zero());

/// The same for a dense grid: count[0] x count[1] x count[2] values (each count 1 to 2^20), x fastest, then y, then z;
/// values other than 0 are occupied cells, at least one.
Shape occupancy_grid(std::span<const std::uint8_t> occupied, const std::array<std::size_t, 3>& count, double size,
                     const Vec3& origin = Vec3::Zero());

/// The surface of voxels as a solid mesh: the faces between occupied and empty cells. Cells from -2^20 to 2^20 - 2,
/// otherwise as in `voxels`. It takes hundreds of bytes per cell; its depths are found by a search over its triangles.
/// Shape::triangles are sorted by the axis of the face, then by cell.
Shape voxel_mesh(std::span<const std::array<std::int32_t, 3>> cells, double size);

}  // namespace tandem
