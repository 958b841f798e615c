// Makes shapes from point clouds, height fields and voxels.
#include "tandem/narrowphase/shape_makers.h"
#include "shapes/written.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace tandem {
namespace {

[[noreturn]] void refuse_number(const std::string& what, double found, const std::string& allowed) {
  throw std::invalid_argument(what + " is " + written(found) + ", allowed: " + allowed);
}

}  // namespace

Shape point_cloud(std::span<const Vec3> points, double radius) {
  if (points.empty()) refuse_number("point cloud: the number of points", 0, ">= 1");
  if (!(radius >= 0) || !std::isfinite(radius)) refuse_number("point cloud: radius", radius, "finite, >= 0");
  Mesh mesh;
  mesh.vertices.assign(points.begin(), points.end());
  mesh.triangles.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) mesh.triangles.push_back({i, i, i});
  return Shape(std::move(mesh)).rounded(radius);
}

Shape height_field(std::span<const double> heights, std::size_t columns, std::size_t rows, double spacing,
                   double bottom) {
  if (columns < 2) refuse_number("height field: columns", static_cast<double>(columns), ">= 2");
  if (rows < 2) refuse_number("height field: rows", static_cast<double>(rows), ">= 2");
  if (heights.size() / columns != rows || heights.size() % columns != 0)
    refuse_number("height field: the number of heights", static_cast<double>(heights.size()),
                  std::to_string(columns) + " x " + std::to_string(rows));
  if (!(spacing > 0) || !std::isfinite(spacing)) refuse_number("height field: spacing", spacing, "finite, > 0");
  if (!std::isfinite(bottom)) refuse_number("height field: bottom", bottom, "finite");
  Mesh mesh;
  mesh.solid = true;
  const double x0 = -0.5 * spacing * static_cast<double>(columns - 1),
               y0 = -0.5 * spacing * static_cast<double>(rows - 1);
  for (const bool top : {true, false})
    for (std::size_t j = 0; j < rows; ++j)
      for (std::size_t i = 0; i < columns; ++i) {
        const double height = heights[j * columns + i];
        if (!(height > bottom) || !std::isfinite(height))
          refuse_number("height field: height of column " + std::to_string(i) + ", row " + std::to_string(j), height,
                        "finite, above the bottom");
        mesh.vertices.push_back(
            {x0 + spacing * static_cast<double>(i), y0 + spacing * static_cast<double>(j), top ? height : bottom});
      }
  const auto corner = [&](std::size_t i, std::size_t j, bool top) {
    return static_cast<std::uint32_t>((top ? 0 : rows * columns) + j * columns + i);
  };
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  };
  for (std::size_t j = 0; j + 1 < rows; ++j)
    for (std::size_t i = 0; i + 1 < columns; ++i) {
      quad(corner(i, j, true), corner(i + 1, j, true), corner(i + 1, j + 1, true), corner(i, j + 1, true));
      quad(corner(i, j, false), corner(i, j + 1, false), corner(i + 1, j + 1, false), corner(i + 1, j, false));
    }
  for (std::size_t i = 0; i + 1 < columns; ++i) {
    quad(corner(i, 0, false), corner(i + 1, 0, false), corner(i + 1, 0, true), corner(i, 0, true));
    const std::size_t last = rows - 1;
    quad(corner(i + 1, last, false), corner(i, last, false), corner(i, last, true), corner(i + 1, last, true));
  }
  for (std::size_t j = 0; j + 1 < rows; ++j) {
    quad(corner(0, j + 1, false), corner(0, j, false), corner(0, j, true), corner(0, j + 1, true));
    const std::size_t last = columns - 1;
    quad(corner(last, j, false), corner(last, j + 1, false), corner(last, j + 1, true), corner(last, j, true));
  }
  return Shape(std::move(mesh));
}

namespace {

/// A cell, or a vertex of the grid, as one number: sorted by (z, y, x).
using GridKey = std::uint64_t;
constexpr std::int32_t grid_reach = 1 << 20;

GridKey grid_key(std::int32_t x, std::int32_t y, std::int32_t z) {
  const auto digit = [](std::int32_t v) { return static_cast<GridKey>(v + grid_reach); };
  return digit(z) << 42 | digit(y) << 21 | digit(x);
}

std::array<std::int32_t, 3> grid_place(GridKey key) {
  const auto digit = [](GridKey bits) { return static_cast<std::int32_t>(bits & 0x1fffff) - grid_reach; };
  return {digit(key), digit(key >> 21), digit(key >> 42)};
}

std::vector<GridKey> sorted_cells(std::span<const std::array<std::int32_t, 3>> cells) {
  std::vector<GridKey> keys;
  keys.reserve(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const std::int32_t v : cells[i])
      if (v < -grid_reach || v >= grid_reach - 1)
        refuse_number("voxel_mesh: cell " + std::to_string(i), v,
                      std::to_string(-grid_reach) + " to " + std::to_string(grid_reach - 2));
    keys.push_back(grid_key(cells[i][0], cells[i][1], cells[i][2]));
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

/// The vertices of the faces between a cell and an empty one, four a face, counterclockwise from outside.
std::vector<GridKey> exposed_faces(const std::vector<GridKey>& cells) {
  std::vector<GridKey> corners;
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const GridKey cell : cells)
      for (const bool above : {false, true}) {
        std::array<std::int32_t, 3> at = grid_place(cell);
        at[axis] += above ? 1 : -1;
        if (at[axis] >= -grid_reach && std::binary_search(cells.begin(), cells.end(), grid_key(at[0], at[1], at[2])))
          continue;
        if (!above) ++at[axis];
        const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
        for (const int turn : {0, 1, 2, 3}) {
          const int k = above ? turn : 3 - turn;
          std::array<std::int32_t, 3> corner = at;
          corner[u] += k == 1 || k == 2;
          corner[v] += k >= 2;
          corners.push_back(grid_key(corner[0], corner[1], corner[2]));
        }
      }
  return corners;
}

}  // namespace

Shape voxels(std::span<const std::array<std::int32_t, 3>> cells, double size, const Vec3& origin) {
  Voxels grid{.cells = {}, .cell_size = size, .origin = origin};
  grid.cells.reserve(cells.size());
  for (const auto& corner : cells) grid.cells.push_back({corner, 0});
  return Shape(grid);
}

Shape occupancy_grid(std::span<const std::uint8_t> occupied, const std::array<std::size_t, 3>& count, double size,
                     const Vec3& origin) {
  std::size_t all = 1;
  for (std::size_t k = 0; k < 3; ++k) {
    if (count[k] < 1 || count[k] > static_cast<std::size_t>(grid_reach))
      refuse_number("occupancy grid: count[" + std::to_string(k) + "]", static_cast<double>(count[k]), "1 to 2^20");
    all *= count[k];
  }
  if (occupied.size() != all)
    refuse_number("occupancy grid: the number of values", static_cast<double>(occupied.size()), std::to_string(all));
  Voxels grid{.cells = {}, .cell_size = size, .origin = origin};
  const auto whole = [](std::size_t place) { return static_cast<std::int32_t>(place); };
  for (std::size_t i = 0; i < all; ++i)
    if (occupied[i] != 0)
      grid.cells.push_back({{whole(i % count[0]), whole(i / count[0] % count[1]), whole(i / count[0] / count[1])}, 0});
  return Shape(grid);
}

Shape voxel_mesh(std::span<const std::array<std::int32_t, 3>> cells, double size) {
  if (cells.empty()) refuse_number("voxel_mesh: the number of cells", 0, ">= 1");
  if (!(size > 0) || !std::isfinite(size)) refuse_number("voxel_mesh: size", size, "finite, > 0");
  const std::vector<GridKey> corners = exposed_faces(sorted_cells(cells));
  std::vector<GridKey> distinct = corners;
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  Mesh mesh;
  mesh.solid = true;
  for (const GridKey corner : distinct) {
    const auto [x, y, z] = grid_place(corner);
    mesh.vertices.push_back(size * Vec3(x, y, z));
  }
  const auto vertex = [&](GridKey corner) {
    return static_cast<std::uint32_t>(std::lower_bound(distinct.begin(), distinct.end(), corner) - distinct.begin());
  };
  for (std::size_t i = 0; i < corners.size(); i += 4) {
    const std::uint32_t a = vertex(corners[i]), b = vertex(corners[i + 1]), c = vertex(corners[i + 2]),
                        d = vertex(corners[i + 3]);
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return Shape(std::move(mesh));
}

}  // namespace tandem
