// Triangles in lanes, a pair a lane: whether they intersect, where they cross; and the point farthest along a
// direction.
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

/// The pose of B in A's frame: columns of the map, then the shift.
struct FrameNumbers {
  double pose[12];
  explicit FrameNumbers(const TriangleTest& test);
};

/// One bit a column; in neither: they do not intersect.
struct TriangleVerdicts {
  std::uint32_t meet, unknown;
};

/// Decides with certainty, in doubles, which of `count` pairs intersect, a pair a lane; pairs left unknown go to
/// `test`. All columns must contain numbers.
TriangleVerdicts compare_triangles(const TriangleRows& pairs, std::size_t count, const TriangleTest& test);

/// The segments shared by two crossing triangles: both ends, in the direction of the curve. A pair a column.
struct CrossingRows {
  static constexpr std::size_t most = TriangleRows::most;
  /// One bit a column; otherwise one triangle lies on one side of the other, and nothing else is set.
  std::uint32_t crosses;
  struct End {
    alignas(64) double point[3][most];  ///< in A's frame
    double part[most];                  ///< parameter on the edge, 0..1
    double edge[most];                  ///< the edge's first corner, plus 3 for an edge of B; an integer
    std::uint32_t from_inside;          ///< one bit a column: that corner is on the inner side of the other triangle
  } end[2];
};

/// The crossings of `count` pairs. All columns must contain numbers.
void cross_triangles(const TriangleRows& pairs, std::size_t count, const TriangleTest& frame, CrossingRows& out);

/// Finds the point farthest along each of some directions; of equals the first. `stride`: from point to point, in
/// numbers. Points first to last - 1; for first > 0 the search continues from the results for the points before.
struct DirectionRows {
  static constexpr std::size_t most = 16;
  alignas(64) double direction[3][most];
  alignas(64) double best[most];   ///< result: the point's number
  alignas(64) double reach[most];  ///< result: its distance along the direction
};
void find_farthest(DirectionRows& rows, std::size_t used, const double* points, std::size_t stride, std::size_t first,
                   std::size_t last);

}  // namespace tandem
