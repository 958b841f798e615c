// Differences of two moving features, for continuous collision detection.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// The differences of two features' points: a triangle's corners relative to a point, or the parallelogram of the
/// differences of two edges, corners in order around it. The features intersect when it contains the origin.
template <std::size_t N>
using Polygon = std::array<Vec3, N>;

/// A Polygon whose corners move on straight lines. Each number is a difference of two coordinates, rounded once; bounds
/// on the errors of that and of later rounding are kept with it.
template <std::size_t N>
struct MovingPolygon {
  Polygon<N> from, to;      // corners at t = 0 and t = 1
  Vec3 e_from, e_to;        // corner 1 - corner 0
  Vec3 f_from, f_to;        // the last corner - corner 0

  double longest_motion() const {  // of a corner
    double most = 0;
    for (std::size_t i = 0; i < N; ++i) most = std::max(most, (to[i] - from[i]).squaredNorm());
    return std::sqrt(most);
  }
  /// The sum of the largest absolute coordinates of the corners.
  double reach() const {
    Vec3 most = Vec3::Zero();
    for (std::size_t i = 0; i < N; ++i) most = most.cwiseMax(from[i].cwiseAbs()).cwiseMax(to[i].cwiseAbs());
    return most.sum();
  }
};

inline MovingPolygon<3> moving_polygon(const Vec3& p0, const std::array<Vec3, 3>& q0, const Vec3& p1,
                                       const std::array<Vec3, 3>& q1) {
  return {{p0 - q0[0], p0 - q0[1], p0 - q0[2]}, {p1 - q1[0], p1 - q1[1], p1 - q1[2]},
          q0[0] - q0[1], q1[0] - q1[1], q0[0] - q0[2], q1[0] - q1[2]};
}

inline MovingPolygon<4> moving_polygon(const std::array<Vec3, 2>& a0, const std::array<Vec3, 2>& b0,
                                       const std::array<Vec3, 2>& a1, const std::array<Vec3, 2>& b1) {
  return {{a0[0] - b0[0], a0[1] - b0[0], a0[1] - b0[1], a0[0] - b0[1]},
          {a1[0] - b1[0], a1[1] - b1[0], a1[1] - b1[1], a1[0] - b1[1]},
          a0[1] - a0[0], a1[1] - a1[0], b0[0] - b0[1], b1[0] - b1[1]};
}

}  // namespace tandem
