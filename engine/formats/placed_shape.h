// Shapes whose pose in a file is a rotation only to some digits.
#pragma once
#include <optional>
#include <vector>

#include "tandem/narrowphase/narrow_phase.h"

namespace tandem {

/// A shape whose points (cores, for shapes with a radius) are at R v + t with an R that is orthonormal only to some
/// digits. Solvers take a rotation's transpose for its inverse; so `pose` has the nearest rotation, and the shape takes
/// the remaining deformation: vertices are moved, capsules lengthened, ellipsoids stretched. Only deformed cylinders
/// and cones become shapes of another kind.
struct PlacedShape {
  Shape shape;
  Pose pose;
  std::optional<Mat3> rest;  ///< the deformation of a cylinder or cone: its points are at pose * (rest * v)
};

PlacedShape place(const Shape& shape, const Pose& pose);

/// The answer of NarrowPhase::solve. The minimum for a deformed cylinder or cone is found by a sequence of undeformed
/// ones, each of which agrees to first order around the normal before. For separated shapes that suffices. Where they
/// overlap, the hull of points on the circles, which grows where the supports exceed it, bounds the answer from the
/// other side (Kelley 1960) and gives further starting points. The remaining gap between the bounds goes into
/// `error_bound`.
PairAnswer solve(const NarrowPhase& narrow_phase, const PlacedShape& a, const PlacedShape& b, Request request,
                 std::vector<Contact>* contacts = nullptr);

/// The answer of NarrowPhase::time_of_impact: conservative, from the distances of solve(); for a mesh and a deformed
/// cylinder or cone, triangle by triangle.
std::optional<double> time_of_impact(const NarrowPhase& narrow_phase, const PlacedShape& a, const Vec3& velocity_a,
                                     const PlacedShape& b, const Vec3& velocity_b, double tmax);

}  // namespace tandem
