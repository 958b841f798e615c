// Screw motions: poses and bounds on speeds.
#pragma once
#include "tandem/narrowphase/motion.h"

namespace tandem {

/// A motion, usually a screw: a rotation by `angle` about a fixed direction, and a path of the origin that is well
/// conditioned for every angle: uniform along the axis, across it along a chord of the circle (the ratio of two sines),
/// never by the axis' position, which is far away for small angles. Or a straight motion: a rotation about a point that
/// moves uniformly.
class ScrewPath {
 public:
  explicit ScrewPath(const Motion& motion);

  Pose at(double t) const;
  /// The largest speed along the unit vector `n` of a point of the box (in the body's frame; `pose` is the body's at
  /// `t`) at time t, per unit time.
  double speed_along(const Vec3& n, const Pose& pose, double t, const Vec3& mid, const Vec3& half) const;
  /// The largest acceleration of such a point.
  double acceleration(const Vec3& mid, const Vec3& half) const;
  double angle() const { return angle_; }  ///< in all, [0, pi]
  /// The longest path of a point of a body whose points are at most `reach` from its origin.
  double length(double reach) const { return along_.norm() + chord_speed_ + angle_ * (reach + centre_.norm()); }

 private:
  Vec3 across_at(double angle) const;

  Motion motion_;
  Vec3 axis_ = Vec3::UnitZ();   // unit, world
  double angle_ = 0;            // [0, pi]
  Vec3 centre_ = Vec3::Zero();  // in the body's frame: the point whose displacement is given; for a screw the origin
  Vec3 along_, across_;         // components of the displacement along and across the axis; straight: all along
  Vec3 square_;                 // axis x across
  double chord_speed_ = 0;      // of the centre, across the axis
};

}  // namespace tandem
