// Two convex bodies as the sum of A and -B, with its support function h.
#pragma once
#include "shapes/minkowski_difference.h"
#include "shapes/round_body.h"

namespace tandem {

/// A - B as the sum of two bodies, in A's frame.
struct RoundPair {
  explicit RoundPair(const MinkowskiDifference& d)
      : difference(d),
        body{RoundBody(d.a, Mat3::Identity(), Vec3::Zero()), RoundBody(d.b, -d.pose.rotation, -d.pose.translation)},
        scale(rounding_scale(d)) {}

  const MinkowskiDifference& difference;
  RoundBody body[2];
  double scale;  ///< as rounding_scale

  /// The point of A - B farthest along n.
  Vec3 support(const Vec3& n) const { return body[0].support(n) + body[1].support(n); }
  /// The point of A - B farthest along -n, given `along`, one farthest along n.
  Vec3 opposite(const Vec3& n, const Vec3& along) const {
    if (body[0].symmetric() && body[1].symmetric()) return 2 * (body[0].centre() + body[1].centre()) - along;
    return support(-n);
  }
};

/// A direction, and the support of A - B along it.
struct Support {
  Vec3 n = Vec3::UnitX();                        ///< unit
  double h = 0;                                  ///< the support of A - B along n: the depth along n, or minus the
                                                 ///< the separation
  Vec3 point[2] = {Vec3::Zero(), Vec3::Zero()};  ///< of the two bodies; their sum is h n if `optimal`
  bool optimal = false;                          ///< h is a local minimum at n
};

}  // namespace tandem
