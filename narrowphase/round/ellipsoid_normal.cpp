#include "round/ellipsoid_normal.h"

#include <algorithm>
#include <cmath>

namespace tandem {

Vec3 nearest_normal(const Vec3& radii, const Vec3& point) {
  int shortest;
  const double unit_length = radii.minCoeff(&shortest);
  const Vec3 q = radii / unit_length, z = point.cwiseAbs() / unit_length;
  const Vec3 longer = (q - Vec3::Ones()).cwiseProduct(q + Vec3::Ones()), qz = q.cwiseProduct(z);
  // The surface's point is q z q / (u + longer), where u makes it lie on it: the root of a function that falls and is
  // curved upwards, which Newton's method reaches from below without passing it.
  double u = std::max(0.0, (qz - longer).maxCoeff());
  Vec3 n = Vec3::Zero();
  if (u == 0) {
    double left = 1;
    for (int i = 0; i < 3; ++i)
      if (z[i] > 0) n[i] = z[i] / longer[i], left -= q[i] * n[i] * (q[i] * n[i]);
    if (left >= 0) {
      for (int i = 0; i < 3; ++i) n[i] = std::copysign(n[i], point[i]);
      n[shortest] = std::sqrt(left);
      return n;
    }
  }
  constexpr int most = 200;
  for (int round = 0; round < most; ++round) {
    double value = -1, fall = 0;
    for (int i = 0; i < 3; ++i) {
      if (!(z[i] > 0)) continue;
      const double at = qz[i] / (u + longer[i]);
      value += at * at, fall += 2 * at * at / (u + longer[i]);
    }
    const double next = u + value / fall;
    if (!(next > u)) break;
    u = next;
  }
  for (int i = 0; i < 3; ++i) n[i] = z[i] > 0 ? std::copysign(z[i] / (u + longer[i]), point[i]) : 0.0;
  return n;
}

}  // namespace tandem
