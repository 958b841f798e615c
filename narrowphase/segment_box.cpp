#include "closed_forms.h"

namespace tandem {

double nearest_on_line(const Vec3& half, const Vec3& middle, const Vec3& along, double reach, double start) {
  // Newton's method on the derivative, which is piecewise linear and rises: exact once it is on the right one of the
  // at most 7 pieces; a bracket keeps it from running in circles.
  double lo = -reach, hi = reach, x = start;
  bool lo_seen = false, hi_seen = false;
  for (int iteration = 0; iteration < 20; ++iteration) {
    double slope = 0, curvature = 0;
    for (int i = 0; i < 3; ++i) {
      const double at = middle[i] + x * along[i];
      const double over = at - std::clamp(at, -half[i], half[i]);
      slope += over * along[i];
      curvature += over != 0 ? along[i] * along[i] : 0.0;
    }
    if (slope == 0) return x;
    if (slope > 0)
      hi = x, hi_seen = true;
    else
      lo = x, lo_seen = true;
    double next = x - slope / curvature;  // a slope comes with a curvature
    if (next <= lo) next = lo_seen ? 0.5 * (lo + hi) : lo;
    if (next >= hi) next = hi_seen ? 0.5 * (lo + hi) : hi;
    if (next == x) return x;
    x = next;
  }
  return x;
}

}  // namespace tandem
