#pragma once
#include <optional>
#include <vector>

#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// A shape whose points, balls about them apart, stand at R v + t of a pose that is a rotation to some digits only.
/// Solvers take a rotation's transpose for its inverse, so `pose` has the nearest rotation and the shape the rest of
/// R: corners are moved, capsules lengthened, ellipsoids stretched. Only cylinders and cones become something else.
struct PlacedShape {
  Shape shape;
  Pose pose;
  std::optional<Mat3> rest;  ///< of a cylinder or cone: its points stand at pose * (rest * v)
};

PlacedShape place(const Shape& shape, const Pose& pose);

/// What NarrowPhase::solve answers. A cylinder or cone with a rest is taken as the hull of points on its rims, to which
/// those are added that its support function finds beyond it along the normal found, until there are none: the hull's
/// distance and the supports' bound the answer from both sides (Kelley 1960). What is left goes into `error_bound`.
PairAnswer solve(const NarrowPhase& narrow_phase, const PlacedShape& a, const PlacedShape& b, Request request,
                 std::vector<Contact>* contacts = nullptr);

}  // namespace tandem
