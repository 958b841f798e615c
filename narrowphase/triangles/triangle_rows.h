// Triangles in lanes, a pair a lane: do they meet, where do they cross; and which point reaches farthest.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "tandem/narrowphase/pose.h"

namespace tandem {

class TriangleTest;

/// Pairs of triangles of two meshes, a pair a column.
struct TriangleRows {
  static constexpr std::size_t most = 8;
  /// [corner][axis]: of A's in A's frame, of B's in B's.
  alignas(64) double a[3][3][most], b[3][3][most];

  void set(std::size_t column, const std::array<Vec3, 3>& of_a, const std::array<Vec3, 3>& of_b) {
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t k = 0; k < 3; ++k) {
        a[c][k][column] = of_a[c][static_cast<Eigen::Index>(k)];
        b[c][k][column] = of_b[c][static_cast<Eigen::Index>(k)];
      }
  }
};

/// How B lies in A's frame: columns of the map, then the shift.
struct FrameNumbers {
  double pose[12];
  explicit FrameNumbers(const TriangleTest& test);
};

/// A bit a column; neither: they are apart.
struct TriangleVerdicts {
  std::uint32_t meet, unknown;
};

/// Do they meet? What doubles can tell for certain, of `count` pairs at once, a pair a lane; `test` of each that is
/// left unknown. All columns must hold numbers.
TriangleVerdicts compare_triangles(const TriangleRows& pairs, std::size_t count, const TriangleTest& test);

/// Where two triangles cross: both ends of the segment that they share, in the curve's sense. A pair a column.
struct CrossingRows {
  static constexpr std::size_t most = TriangleRows::most;
  std::uint32_t crosses;  ///< a bit a column; else one lies to one side of the other, and nothing else is set
  struct End {
    alignas(64) double point[3][most];  ///< in A's frame
    double part[most];                  ///< how far along its edge, 0..1
    double edge[most];                  ///< the edge's first corner, 3 more for an edge of B; a whole number
    std::uint32_t from_inside;          ///< a bit a column: that corner is on the inner side of the other triangle
  } end[2];
};

/// Crossings of `count` pairs. All columns must hold numbers.
void cross_triangles(const TriangleRows& pairs, std::size_t count, const TriangleTest& frame, CrossingRows& out);

/// Which point reaches farthest along each of some directions; of equals the first. `stride`: from point to point, in
/// numbers. Points first to last - 1; from another than 0 on the search goes on from what was found of those before.
struct DirectionRows {
  static constexpr std::size_t most = 16;
  alignas(64) double direction[3][most];
  alignas(64) double best[most];   ///< found: the point's number
  alignas(64) double reach[most];  ///< and how far it reaches
};
void find_farthest(DirectionRows& rows, std::size_t used, const double* points, std::size_t stride, std::size_t first,
                   std::size_t last);

}  // namespace tandem
