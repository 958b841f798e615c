#pragma once
#include "tandem/narrowphase/motion.h"

namespace tandem {

/// A motion, as a rule a screw: a turn by `angle` about a fixed direction, and a path of the origin that is well
/// conditioned for every angle: along the axis evenly, across it by a chord of the circle (the ratio of two sines),
/// never by the axis' place, which is far away where the angle is small. Or straight: a turn about a point that goes
/// evenly along.
class ScrewPath {
 public:
  explicit ScrewPath(const Motion& motion);

  Pose at(double t) const;
  /// The most that a point of the box (in the body's frame; `pose` is the body's at `t`) moves along unit `n` in unit
  /// time, at its speed at time t.
  double speed_along(const Vec3& n, const Pose& pose, double t, const Vec3& mid, const Vec3& half) const;
  /// The most by which such a point's velocity changes in unit time.
  double acceleration(const Vec3& mid, const Vec3& half) const;
  double angle() const { return angle_; }  ///< that it turns by, [0, pi]
  /// The most that a point of a body goes all in all, which reaches so far from its origin.
  double length(double reach) const { return along_.norm() + chord_speed_ + angle_ * (reach + centre_.norm()); }

 private:
  Vec3 across_at(double angle) const;

  Motion motion_;
  Vec3 axis_ = Vec3::UnitZ();   // unit, world
  double angle_ = 0;            // [0, pi]
  Vec3 centre_ = Vec3::Zero();  // of the body's frame: what the displacement is of, the origin of a screw
  Vec3 along_, across_;         // of its displacement: along the axis, square to it; straight: all along
  Vec3 square_;                 // axis x across
  double chord_speed_ = 0;      // of the centre, across the axis
};

}  // namespace tandem
