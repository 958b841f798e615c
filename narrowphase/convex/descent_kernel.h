// The loop of GJK for two polytopes.
#pragma once
#include "convex/simplex.h"

namespace tandem {

/// The conditions that end GJK's loop, as in `gjk`. `at_once`: so does a first direction that does not show a larger
/// separation than this, with an empty simplex. Then the units of rounding: `rounding` as a length, `scale` as in
/// MinkowskiDifference, `size` of relative tolerances.
struct DescentLimits {
  double tolerance, beyond, within, at_once;
  double rounding, scale, size;
};

/// GJK's loop for two polytopes from the direction r.v (not zero): sets all of r but the weights; `end` becomes
/// `inside` or is unchanged. The same bits on every instruction set.
using DescentKernel = void (*)(const MinkowskiDifference& d, const DescentLimits& limits, GjkResult& r);
DescentKernel descent_kernel();

}  // namespace tandem
