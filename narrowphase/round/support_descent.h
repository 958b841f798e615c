// The minima of h, how far A - B reaches along a direction: by Newton's method, and by convex problems.
#pragma once
#include "convex/gjk.h"
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
  /// The same along -n, where `along` supports n.
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

/// How far h and the points, which are of the two bodies, leave the answer open (metres): apart, the bodies are no
/// farther from each other than the points and no nearer than -h; in each other, n may still turn to where the points
/// are.
double doubt(const Support& s);

/// Goes downhill on h over the unit sphere from direction n, by Newton steps
/// within a cell of the sphere where each body has one smooth piece, and along
/// the circles where the cells meet. Ends at a local minimum, which is the
/// distance where h < 0 (Cameron and Culley 1986: the least translation; Newton
/// with an active set), or as soon as h < below. h is always what the bodies'
/// supports along n say; where that and the two points do not bear out what was
/// found, settle() goes on.
Support minimize(const RoundPair& pair, const Vec3& n, double below);

/// The same by a sequence of convex problems, slower, but nothing can mislead it: A - B is moved away from the origin
/// against n, GJK finds the direction to its nearest point, and n turns there, until it turns no more. h never
/// increases (the concave part of h(n) - c |n| linearised at n: Yuille and Rangarajan 2003).
Support settle(const RoundPair& pair, const Vec3& n, double below);

/// The disc of body `which` that faces `side` times its axis as the supporting
/// face: optimal where it meets the other body's face. Else `away` is the
/// tangent in which h falls most, as long as it falls fast.
Support facing_disc(const RoundPair& pair, int which, double side, Vec3& away);

}  // namespace tandem
