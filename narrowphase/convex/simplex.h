#pragma once
#include "shapes/minkowski_difference.h"

namespace tandem {

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

}  // namespace tandem
