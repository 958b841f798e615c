// The deviation of a matrix from a rotation.
#pragma once
#include <algorithm>
#include <cmath>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// The largest entry of r^T r - 1: 0 for orthonormal columns.
inline double skewness(const Mat3& r) {
  const auto off = [&](int i, int j) {
    return std::abs(r(0, i) * r(0, j) + (r(1, i) * r(1, j) + r(2, i) * r(2, j)) - (i == j ? 1 : 0));
  };
  return std::max({off(0, 0), off(1, 1), off(2, 2), off(0, 1), off(0, 2), off(1, 2)});
}

}  // namespace tandem
