#pragma once
#include "tandem/narrowphase/pose.h"

namespace tandem {

/// The squares of vectors shorter than this may have lost digits, or all of them. Lengths of shapes are 1e-30 and more,
/// but two points of theirs may lie apart by any number, however small.
inline constexpr double shortest_squared = 1e-140;

/// v over its length, which is v.norm(): of length 1 to rounding, however short or long v is; 0 where v is.
inline Vec3 unit(const Vec3& v, double length) {
  if (length > shortest_squared && length < 1 / shortest_squared) return v / length;
  const double most = v.cwiseAbs().maxCoeff();
  if (!(most > 0)) return v;
  const Vec3 w = v / most;
  return w / w.norm();
}
inline Vec3 unit(const Vec3& v) { return unit(v, v.norm()); }

}  // namespace tandem
