// A posed convex shape for the reference solver.
#pragma once
#include <vector>

#include "real.h"
#include "tandem/narrowphase/shape.h"

namespace tandem::reference {

/// A convex shape as a core and a radius about each of its points (spheres: a point, capsules: a segment), in the real
/// numbers R v + t, relative to an origin.
class PosedCore {
 public:
  /// `shape` is convex and bounded; it must outlive the core.
  PosedCore(const Shape& shape, const Pose& pose, const Vec3& origin);

  /// A point of the core farthest along d (any length; 0 gives any point).
  Vec support(const Vec& d) const;
  Real radius() const;
  /// A bound on the distance of any point of the core from the origin.
  Real reach() const { return reach_; }
  bool is_polytope() const;
  const Vec& translation() const { return translation_; }
  Vec axis(int k) const { return columns_[k]; }  ///< column of the rotation
  const Shape& shape() const { return shape_; }

 private:
  Vec hull_support(const Vec& d) const;

  const Shape& shape_;
  Vec columns_[3];
  Vec translation_;
  Real reach_;
};

}  // namespace tandem::reference
