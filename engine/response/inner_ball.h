// A ball inside a shape: the part of a continuous body that is kept out of what the body touches.
#pragma once
#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// A ball inside a shape, in its frame, metres.
struct InnerBall {
  Vec3 centre = Vec3::Zero();
  double radius = 0;  ///< 0: there is none
};

/// The ball about the centre of mass, or, for a closed mesh, the largest of some that are tried under its triangles.
InnerBall inner_ball(const NarrowPhase& narrow, const Shape& shape);

}  // namespace tandem
