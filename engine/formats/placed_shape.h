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

/// What NarrowPhase::solve answers. A cylinder or cone with a rest is followed to its minimum by ones without, each the
/// same to first order around the one before's normal. Apart that is all there is to it; where the two overlap, the
/// hull of points on the rims, which grows where the supports reach beyond it, bounds the answer from the other side
/// (Kelley 1960) and shows where else to begin. What is left between the two goes into `error_bound`.
PairAnswer solve(const NarrowPhase& narrow_phase, const PlacedShape& a, const PlacedShape& b, Request request,
                 std::vector<Contact>* contacts = nullptr);

/// What NarrowPhase::time_of_impact answers: conservative, found by what solve() says of the distance on the way; of a
/// mesh and a cylinder or cone with a rest, triangle by triangle.
std::optional<double> time_of_impact(const NarrowPhase& narrow_phase, const PlacedShape& a, const Vec3& velocity_a,
                                     const PlacedShape& b, const Vec3& velocity_b, double tmax);

}  // namespace tandem
