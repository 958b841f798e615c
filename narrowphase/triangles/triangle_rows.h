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

}  // namespace tandem
