#include "tandem/narrowphase/shape_makers.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace tandem {
namespace {

[[noreturn]] void refuse(const std::string& what, double found, const std::string& allowed) {
  throw std::invalid_argument(what + " is " + std::to_string(found) + ", allowed: " + allowed);
}

}  // namespace

Shape point_cloud(std::span<const Vec3> points, double radius) {
  if (points.empty()) refuse("point cloud: the number of points", 0, ">= 1");
  if (!(radius >= 0) || !std::isfinite(radius)) refuse("point cloud: radius", radius, "finite, >= 0");
  Mesh mesh;
  mesh.vertices.assign(points.begin(), points.end());
  mesh.triangles.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) mesh.triangles.push_back({i, i, i});
  return Shape(std::move(mesh)).rounded(radius);
}

Shape height_field(std::span<const double> heights, std::size_t columns, std::size_t rows, double spacing, double bottom) {
  if (columns < 2) refuse("height field: columns", static_cast<double>(columns), ">= 2");
  if (rows < 2) refuse("height field: rows", static_cast<double>(rows), ">= 2");
  if (heights.size() / columns != rows || heights.size() % columns != 0)
    refuse("height field: the number of heights", static_cast<double>(heights.size()),
           std::to_string(columns) + " x " + std::to_string(rows));
  if (!(spacing > 0) || !std::isfinite(spacing)) refuse("height field: spacing", spacing, "finite, > 0");
  if (!std::isfinite(bottom)) refuse("height field: bottom", bottom, "finite");
  Mesh mesh;
  mesh.solid = true;
  const double x0 = -0.5 * spacing * static_cast<double>(columns - 1), y0 = -0.5 * spacing * static_cast<double>(rows - 1);
  for (const bool top : {true, false})
    for (std::size_t j = 0; j < rows; ++j)
      for (std::size_t i = 0; i < columns; ++i) {
        const double height = heights[j * columns + i];
        if (!(height > bottom) || !std::isfinite(height))
          refuse("height field: height of column " + std::to_string(i) + ", row " + std::to_string(j), height,
                 "finite, above the bottom");
        mesh.vertices.push_back({x0 + spacing * static_cast<double>(i), y0 + spacing * static_cast<double>(j), top ? height : bottom});
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

}  // namespace tandem
