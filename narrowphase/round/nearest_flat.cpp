// The point nearest the origin of the hull of points in a plane.
#include "round/nearest_flat.h"

#include <algorithm>
#include <cmath>

#include "tolerances.h"

namespace tandem {

NearestFlat nearest_flat(const PlaneSum* p, int count) {
  NearestFlat best;
  best.x = p[0].x, best.y = p[0].y;
  if (count == 1) return best;
  double least = infinity;
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j) {
      const double dx = p[j].x - p[i].x, dy = p[j].y - p[i].y, length2 = dx * dx + dy * dy;
      const double t = length2 > 0 ? std::clamp(-(p[i].x * dx + p[i].y * dy) / length2, 0.0, 1.0) : 0.0;
      // From the nearer end: less cancellation.
      const double x = t <= 0.5 ? p[i].x + t * dx : p[j].x - (1 - t) * dx;
      const double y = t <= 0.5 ? p[i].y + t * dy : p[j].y - (1 - t) * dy;
      const double squared = x * x + y * y;
      if (!(squared < least)) continue;
      least = squared;
      best = {x, y, {t < 1 ? i : j, j, 0}, {t < 1 ? 1 - t : 1.0, t, 0}, t > 0 && t < 1 ? 2 : 1};
    }
  for (int i = 0; i < count; ++i)
    for (int j = i + 1; j < count; ++j)
      for (int k = j + 1; k < count; ++k) {
        const double a = p[j].x * p[k].y - p[j].y * p[k].x, b = p[k].x * p[i].y - p[k].y * p[i].x,
                     c = p[i].x * p[j].y - p[i].y * p[j].x;
        const double sum = a + b + c;
        if (sum != 0 && a / sum >= 0 && b / sum >= 0 && c / sum >= 0)
          return {0, 0, {i, j, k}, {a / sum, b / sum, c / sum}, 3};
      }
  return best;
}

bool surrounded(const PlaneSum* p, int count, double tolerance) {
  for (int i = 0; i < count; ++i) {
    const double length = std::sqrt(p[i].x * p[i].x + p[i].y * p[i].y);
    if (length <= tolerance) continue;
    bool left = false, right = false;
    for (int j = 0; j < count; ++j) {
      const double side = (p[i].x * p[j].y - p[i].y * p[j].x) / length;
      left = left || side > tolerance;
      right = right || side < -tolerance;
    }
    if (!left || !right) return false;
  }
  return count > 2;
}

}  // namespace tandem
