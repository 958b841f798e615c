// The nearest points of two features, each a corner, a line, a cone's lateral surface or a circle: by closed forms, or
// Newton's method in one or two angles.
#pragma once
#include <utility>

#include "convex/projection.h"
#include "tolerances.h"

namespace tandem {

/// A feature of a core's surface, extended beyond its ends: a point; a plane; a line, or the surface at distance
/// `radius` from it; an infinite cone; a circle.
struct Feature {
  Surface surface = Surface::none;
  Vec3 point;           ///< the corner; the foot on the plane; the middle of the line or circle; the apex
  Vec3 axis;            ///< of the plane, outwards; along the line; of the cone, towards its apex
  Vec3 u, v;            ///< axes of the circle's plane
  double c = 1, s = 0;  ///< position on the circle, along u and v
  double radius = 0;
  double sine = 0, cosine = 1;  ///< of the cone's normals to the plane perpendicular to its axis
  double low = 0, high = 0;     ///< the line's ends; on the cone, distances down from the apex
  std::uint32_t face = 0;       ///< for a hull
};

/// The nearest points of two features, or those of deepest penetration. If one lies beyond the feature's end, the end.
struct NearestPoints {
  Vec3 a, b;
  Vec3 n;  ///< unit, from a to b if they are separated; on input an approximation of it

  /// The result of `find` for a and b exchanged.
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

/// v normalised; `otherwise` if it is too short to have a direction.
inline Vec3 unit_or(const Vec3& v, const Vec3& otherwise) {
  const double length2 = v.squaredNorm();
  return length2 > tolerance::shortest_squared ? Vec3(v / std::sqrt(length2)) : otherwise;
}

/// The nearest points of two features other than faces; w.n approximates the direction. False if they lie beyond the
/// features.
bool nearest_points(const Feature& a, const Feature& b, double rounding, NearestPoints& w);

}  // namespace tandem
