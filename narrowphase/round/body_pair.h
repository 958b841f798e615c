// Two convex bodies as the sum A - B, and what supports it along a direction.
#pragma once
#include "shapes/minkowski_difference.h"
#include "shapes/round_body.h"

namespace tandem {

/// The unit of absolute rounding errors: a hull may lie far from its own origin.
inline double rounding_scale(const MinkowskiDifference& d) {
  const auto off_origin = [](const ConvexView& v) { return v.hull != nullptr ? v.hull->inside.norm() : 0.0; };
  return d.scale() + off_origin(d.a) + off_origin(d.b);
}

/// A - B as the sum of two bodies, in A's frame.
struct RoundPair {
  explicit RoundPair(const MinkowskiDifference& d)
      : difference(d),
        body{RoundBody(d.a, Mat3::Identity(), Vec3::Zero()), RoundBody(d.b, -d.pose.rotation, -d.pose.translation)},
        scale(rounding_scale(d)) {}

  const MinkowskiDifference& difference;
  RoundBody body[2];
  double scale;  ///< rounding_scale

  /// A point of A - B farthest along n.
  Vec3 support(const Vec3& n) const { return body[0].support(n) + body[1].support(n); }
  /// A point of A - B farthest along -n, where `along` is one along n.
  Vec3 opposite(const Vec3& n, const Vec3& along) const {
    if (body[0].symmetric() && body[1].symmetric()) return 2 * (body[0].centre() + body[1].centre()) - along;
    return support(-n);
  }
};

/// A direction and what supports A - B there.
struct Support {
  Vec3 n = Vec3::UnitX();                        ///< unit
  double h = 0;                                  ///< how far A - B reaches along n: the depth along n, or minus
                                                 ///< the separation
  Vec3 point[2] = {Vec3::Zero(), Vec3::Zero()};  ///< of the two bodies; their sum is h n where `optimal`
  bool optimal = false;                          ///< no direction near n reaches less far
};

}  // namespace tandem
