// The nearest points of two features, a corner, a line, a cone's side or a circle: closed forms, or Newton's method in
// an angle or two.
#pragma once
#include <utility>

#include "convex/projection.h"
#include "tolerances.h"

namespace tandem {

/// Of a core's surface, as far as it goes, and beyond: a point; a plane; a line, or what is `radius` from it; the
/// mantle of an endless cone; a circle.
struct Feature {
  Surface surface = Surface::none;
  Vec3 point;           ///< the corner; the foot on the plane; the middle of the line or circle; the apex
  Vec3 axis;            ///< of the plane, outwards; along the line; of the cone, towards its apex
  Vec3 u, v;            ///< the circle's plane
  double c = 1, s = 0;  ///< where on the circle, along u and v
  double radius = 0;
  double sine = 0, cosine = 1;  ///< of the normals to the cone with the plane square to its axis
  double low = 0, high = 0;     ///< the line's ends; on the cone, down from the apex
  std::uint32_t face = 0;       ///< of a hull
};

/// Between two features: their nearest points, or those that are farthest in each other. Where one lies beyond the
/// feature's end, the end.
struct NearestPoints {
  Vec3 a, b;
  Vec3 n;  ///< unit, from a to b where they are apart; before it is known about that

  /// What `find` says of them with a and b exchanged.
  template <class Find>
  bool exchanged(const Find& find) {
    exchange();
    const bool found = find();
    exchange();
    return found;
  }

 private:
  void exchange() {
    std::swap(a, b);
    n = -n;
  }
};

/// v of unit length; `otherwise` where it is too short to have a direction.
inline Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length2 = v.squaredNorm();
  return length2 > tolerance::shortest_squared ? Vec3(v / std::sqrt(length2)) : otherwise;
}

/// The nearest points of two features that are no faces; w.n tells about where to. False where they lie beyond them.
bool nearest_points(const Feature& a, const Feature& b, double rounding, NearestPoints& w);

}  // namespace tandem
