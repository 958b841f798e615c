#pragma once
#include "support.h"

namespace tandem {

/// A point of the Minkowski difference A - B and the point of A it comes from.
struct MinkowskiPoint {
  Vec3 w;
  Vec3 a;
};

/// A - B of two cores in A's frame.
struct MinkowskiDifference {
  const ConvexView& a;
  const ConvexView& b;
  RelativePose pose;

  MinkowskiPoint support(const Vec3& d) const {
    const Vec3 pa = core_support(a, d);
    const Vec3 pb = pose.rotation * core_support(b, -(pose.rotation.transpose() * d)) + pose.translation;
    return {pa - pb, pa};
  }
  /// The unit of absolute rounding errors.
  double scale() const { return a.size + b.size + pose.translation.norm(); }
};

struct Simplex {
  MinkowskiPoint p[4];
  double weight[4];  ///< of the point nearest the origin
  int count = 0;
};

/// Where GJK stopped (Gilbert, Johnson, Keerthi 1988; the duality gap bounds the error).
struct GjkResult {
  enum class End { separated, near, inside } end;
  double upper = 0;  ///< distance of `v`: the cores are no farther apart
  double lower = 0;  ///< the cores are at least this far apart; <= 0 says nothing
  Vec3 v = Vec3::Zero();
  Simplex simplex;
};

/// Distance of the cores. Stops as soon as the distance is known to be > beyond or <= within, or the gap is below
/// tolerance x distance. `near`: so close to touching that the depth solver must decide.
GjkResult gjk(const MinkowskiDifference& d, double tolerance, double beyond, double within);

/// Sets the points of the answer from its signed distance (of the cores, < 0) and normal: B is moved out along the
/// normal, where the nearest points are the pair sought, whichever of its faces, edges and corners touch. On curved
/// surfaces it also improves the normal and the distance.
void pair_points(const MinkowskiDifference& d, LocalAnswer& answer);

/// Signed distance, normal, witness points of two bounded convex shapes: GJK on the cores, and the depth solver
/// where they overlap or nearly do. `tolerance` is relative to the shapes' size, 0: to rounding.
LocalAnswer gjk_signed_distance(const MinkowskiDifference& d, double tolerance);

/// Do the shapes touch? Cheaper than the distance.
bool gjk_collide(const MinkowskiDifference& d, double tolerance);

}  // namespace tandem
