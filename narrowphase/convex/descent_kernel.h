#pragma once
#include "convex/simplex.h"

namespace tandem {

/// What ends GJK's descent, as `gjk` has it; `at_once`: so does a first direction that does not show them farther apart
/// than this, with the simplex empty. Then the units of rounding: `rounding` in lengths, `scale` as
/// MinkowskiDifference has it, `size` that of relative tolerances.
struct DescentLimits {
  double tolerance, beyond, within, at_once;
  double rounding, scale, size;
};

/// GJK's descent between two polytopes from the direction r.v (not zero): fills all of r but the weights and `end`,
/// which becomes `inside` or is left as it is. The same bits on every instruction set.
using DescentKernel = void (*)(const MinkowskiDifference& d, const DescentLimits& limits, GjkResult& r);
DescentKernel descent_kernel();

}  // namespace tandem
