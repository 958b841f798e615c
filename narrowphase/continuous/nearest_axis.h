// The direction of a polygon's point nearest the origin.
#pragma once
#include <algorithm>
#include <cmath>

#include "continuous/moving_polygon.h"
#include "tolerances.h"

namespace tandem {

/// A direction, and the separation of a polygon from the origin along it.
struct NearestAxis {
  Vec3 n;  // unit, or zero if none is known
  double gap;
};

/// The vector from the origin to the nearest point of a segment, made perpendicular to it where the point lies between
/// the ends: the plain difference has an error proportional to the segment's length.
inline Vec3 nearest_of_segment(const Vec3& p, const Vec3& q) {
  const Vec3 d = q - p;
  const double dd = d.squaredNorm(), along = -d.dot(p);
  if (!(along > 0)) return p;
  if (!(along < dd)) return q;
  const Vec3 x = p + along / dd * d;
  return x - x.dot(d) / dd * d;
}

/// The direction of the point of a plane polygon nearest the origin, in doubles; callers prove what they conclude from
/// it.
template <std::size_t N>
NearestAxis nearest_axis(const Polygon<N>& w, const Vec3& e, const Vec3& f) {
  const Vec3 m = e.cross(f);
  const double mm = m.squaredNorm();
  if (mm > tolerance::slanting2 * tolerance::slanting2 * e.squaredNorm() * f.squaredNorm()) {
    bool inside = true;
    for (std::size_t i = 0; i < N; ++i) inside = inside && w[i].cross(w[i + 1 == N ? 0 : i + 1]).dot(m) >= 0;
    if (inside) {
      const double height = w[0].dot(m), length = std::sqrt(mm);
      return {m * (height < 0 ? -1 / length : 1 / length), std::abs(height) / length};
    }
  }
  Vec3 best = w[0];
  double least = infinity;
  for (std::size_t i = 0; i < N; ++i) {
    const Vec3 x = nearest_of_segment(w[i], w[i + 1 == N ? 0 : i + 1]);
    if (const double xx = x.squaredNorm(); xx < least) best = x, least = xx;
  }
  const double gap = std::sqrt(least);
  if (!(gap > 0)) return {Vec3::Zero(), 0};
  return {best / gap, gap};
}

/// An upper bound, to rounding, on the distance of a polygon from the origin: that of a point of it nearby.
template <std::size_t N>
double distance_bound(const Polygon<N>& w) {
  double least = infinity;
  const auto triangle = [&](const Vec3& p, const Vec3& q, const Vec3& r) {
    const Vec3 m = (q - p).cross(r - p);
    const double x = std::max(0.0, q.cross(r).dot(m)), y = std::max(0.0, r.cross(p).dot(m)),
                 z = std::max(0.0, p.cross(q).dot(m));
    const double sum = x + y + z;
    if (sum > 0) least = std::min(least, (x / sum * p + y / sum * q + z / sum * r).squaredNorm());
  };
  for (std::size_t i = 0; i < N; ++i)
    least = std::min(least, nearest_of_segment(w[i], w[i + 1 == N ? 0 : i + 1]).squaredNorm());
  for (std::size_t i = 2; i < N; ++i) triangle(w[0], w[i - 1], w[i]);
  return std::sqrt(least);
}

}  // namespace tandem
