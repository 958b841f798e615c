// Points moved into convex cores.
#include "convex/projection.h"

#include <algorithm>
#include <cmath>

#include "shapes/support.h"

namespace tandem {

Projection move_into(const ConvexView& v, Vec3& p, double least) {
  // Avoids branches where possible: the side of a face on which a point lies is unpredictable.
  const double half = 0.5 * v.param[1];
  const auto clamp = [&](int k, double most) {
    const bool well_within = std::abs(p[k]) < most - least;
    p[k] = std::min(std::max(p[k], -most), most);
    return well_within;
  };
  switch (v.kind) {
    case ShapeKind::box: {
      constexpr Surface by_count[] = {Surface::corner, Surface::straight, Surface::flat, Surface::none};
      const int within = clamp(0, v.param[0]) + clamp(1, v.param[1]) + clamp(2, v.param[2]);
      return {within == 3, by_count[within]};
    }
    case ShapeKind::capsule:
      p[0] = p[1] = 0;
      return {false, clamp(2, half) ? Surface::straight : Surface::corner};
    case ShapeKind::cylinder: {
      constexpr Surface by_both[] = {Surface::circle, Surface::straight, Surface::flat, Surface::none};
      const double rho = std::sqrt(p[0] * p[0] + p[1] * p[1]), radius = v.param[0];
      const int within = clamp(2, half) + 2 * (rho < radius - least);
      const double k = radius / std::max(rho, radius);
      p[0] *= k, p[1] *= k;
      return {within == 3, by_both[within]};
    }
    case ShapeKind::cone: {
      // In the half plane of p the lateral line goes from (radius, -half) to (0, half).
      const double rho = std::sqrt(p[0] * p[0] + p[1] * p[1]), radius = v.param[0], length = v.param[1];
      const double outside = length * rho + radius * (p[2] - half), slant2 = radius * radius + length * length;
      if (outside < 0 && p[2] > -half) return {p[2] > least - half && outside < -least * (radius + length)};
      if (p[2] <= -half && rho <= radius) {
        p[2] = -half;
        return {false, Surface::flat};
      }
      const double down = std::min(std::max((radius * rho - length * (p[2] - half)) / slant2, 0.0), 1.0);
      const double k = rho > 0 ? down * radius / rho : 0.0;
      p = {k * p[0], k * p[1], half - down * length};
      return {false, down == 0 ? Surface::corner : down == 1 ? Surface::circle : Surface::side};
    }
    case ShapeKind::ellipsoid: {
      const Vec3 r{v.param[0], v.param[1], v.param[2]};
      const double out = p.cwiseQuotient(r).norm();
      if ((1 - out) * r.minCoeff() > least) return {true};
      if (out > 1) p /= out;
      return {};
    }
    case ShapeKind::sphere:
    case ShapeKind::halfspace:
    case ShapeKind::plane:
    case ShapeKind::convex:
    case ShapeKind::triangle:
    case ShapeKind::voxels:
    case ShapeKind::mesh:
      break;
  }
  p = core_centre(v);
  return {};
}

}  // namespace tandem
