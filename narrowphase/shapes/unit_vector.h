// Normalisation of vectors of any length.
#pragma once
#include "tandem/narrowphase/pose.h"
#include "tolerances.h"

namespace tandem {

using tolerance::shortest_squared;

/// v over its length, which is v.norm(): unit to rounding, however short or long v is; 0 for v = 0.
inline Vec3 unit(const Vec3& v, double length) {
  if (length > tolerance::shortest_squared && length < 1 / tolerance::shortest_squared) return v / length;
  const double most = v.cwiseAbs().maxCoeff();
  if (!(most > 0)) return v;
  const Vec3 w = v / most;
  return w / w.norm();
}
inline Vec3 unit(const Vec3& v) { return unit(v, v.norm()); }

}  // namespace tandem
