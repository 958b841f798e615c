#pragma once
#include <limits>

#include "support.h"

namespace tandem {

/// A point of the Minkowski difference A - B and the point of A it comes from. For polytopes the vertices of A and B
/// are numbered.
struct MinkowskiPoint {
  Vec3 w;
  Vec3 a;
  std::uint32_t vertex_a;
  std::uint32_t vertex_b;
};

/// A - B of two cores in A's frame.
struct MinkowskiDifference {
  const ConvexView& a;
  const ConvexView& b;
  RelativePose pose;
  MinkowskiKernel kernel = minkowski_kernel();

  MinkowskiPoint support(const Vec3& n) const {
    MinkowskiPoint p;
    kernel(*this, n, p);
    return p;
  }
  /// p - q of two points of polytopes: exact to the length of the edges it is made of, not to that of p and q.
  Vec3 edge(const MinkowskiPoint& p, const MinkowskiPoint& q) const {
    return (core_vertex(a, p.vertex_a) - core_vertex(a, q.vertex_a)) -
           pose.rotation * (core_vertex(b, p.vertex_b) - core_vertex(b, q.vertex_b));
  }
  bool polytopes() const { return is_polytope(a.kind) && is_polytope(b.kind); }
  /// The unit of absolute rounding errors.
  double scale() const { return a.size + b.size + pose.translation.norm(); }
};

/// A side of a triangle, and what is square to it of the way from it to the opposite corner.
struct Height {
  Vec3 side, height;

  Height(const Vec3& along, const Vec3& slant) : side(along), height(slant) {
    const double length2 = along.squaredNorm();
    // Twice: the second takes what the first left by rounding.
    for (int i = 0; i < 2 && length2 > 0; ++i) height -= (height.dot(side) / length2) * side;
  }
};
/// Over the longest side: a sliver's normal, side x height, is rounded about that side only, where its corners are
/// near.
inline Height height_of(const Vec3& ab, const Vec3& bc, const Vec3& ca) {
  const double ab2 = ab.squaredNorm(), bc2 = bc.squaredNorm(), ca2 = ca.squaredNorm();
  if (ab2 >= bc2 && ab2 >= ca2) return {ab, bc};
  return bc2 >= ca2 ? Height(bc, ca) : Height(ca, ab);
}
/// The squared height of a triangle over its longest side, relative to that side's square: flatter ones are segments.
inline constexpr double flat_squared = 1e-28;

/// The unit of relative tolerances.
inline double larger(const MinkowskiDifference& d) { return std::max(d.a.size, d.b.size); }

struct Simplex {
  MinkowskiPoint p[4];
  double weight[4];  ///< of the point nearest the origin
  int count = 0;
};

/// Where GJK stopped (Gilbert, Johnson, Keerthi 1988; the duality gap bounds the error).
struct GjkResult {
  enum class End { separated, near, inside } end;
  double upper = 0;       ///< distance of `v`: the cores are no farther apart
  double lower = 0;       ///< the cores are at least this far apart; <= 0 says nothing
  double along = 0;       ///< as far as they are apart along -v
  Vec3 v = Vec3::Zero();  ///< the last nearest point; -v is the direction to start a similar query from
  Simplex simplex;
};

/// Distance of the cores. Stops as soon as the distance is known to be > beyond or <= within, or the gap is below
/// tolerance x distance. `near`: so close to touching that the depth solver must decide. `start`: a direction from A
/// to B, in A's frame, not zero; without it the one between the centres.
GjkResult gjk(const MinkowskiDifference& d, double tolerance, double beyond, double within,
              const Vec3* start = nullptr);

/// Sets the points of the answer from its signed distance (of the cores, < 0) and normal: B is moved out along the
/// normal, where the nearest points are the pair sought, whichever of its faces, edges and corners touch. On curved
/// surfaces it also improves the normal and the distance.
void pair_points(const MinkowskiDifference& d, LocalAnswer& answer);

/// Signed distance, normal, witness points of two bounded convex shapes: GJK on the cores, and the depth solver
/// where they overlap or nearly do; of polytopes the face on which a portal ends, where that is sure to be the nearest.
/// `tolerance` is relative to the shapes' size, 0: to rounding, as polytopes always are. Ends early for shapes that are
/// more than `beyond` apart: signed_distance is then a separation along the normal, the points are not set.
LocalAnswer gjk_signed_distance(const MinkowskiDifference& d, double tolerance, const Vec3* start = nullptr,
                                double beyond = std::numeric_limits<double>::infinity());

/// Do the shapes touch? Cheaper than the distance. `direction`, where they are apart: one that says so.
bool gjk_collide(const MinkowskiDifference& d, double tolerance, const Vec3* start = nullptr,
                 Vec3* direction = nullptr);

}  // namespace tandem
