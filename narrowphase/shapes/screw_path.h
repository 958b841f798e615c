// Screw motions: poses and bounds on speeds.
#pragma once
#include <optional>

#include "tandem/narrowphase/motion.h"

namespace tandem {

/// A motion, usually a screw: a rotation by `angle` about a fixed direction, and a path of the origin that is well
/// conditioned for every angle: uniform along the axis, across it along a chord of the circle (the ratio of two sines),
/// never by the axis' position, which is far away for small angles. Or a straight motion: a rotation about a point that
/// moves uniformly.
///
/// Bounds on speeds are those of points that the body's surface cannot leave. A body of revolution that spins about its
/// own axis looks the same at all times: where this lowers the bounds, its points are taken to follow its axis only.
class ScrewPath {
 public:
  /// `revolution`: the shape is one of revolution about this axis of its frame through the origin.
  explicit ScrewPath(const Motion& motion, std::optional<Vec3> revolution = {});

  Pose at(double t) const;
  /// The largest speed along the unit vector `n` of a point of the box (in the body's frame; `pose` is the body's at
  /// `t`) at time t, per unit time; and the speed of a unit vector `n` that rotates with the body.
  struct Speed {
    double along, of_normal;
  };
  Speed speed_along(const Vec3& n, const Pose& pose, double t, const Vec3& mid, const Vec3& half) const;
  /// The highest speed of such a point in any direction, at any time.
  double fastest(const Vec3& mid, const Vec3& half) const;
  /// Bounds on the acceleration of such points, along `n`: `square` times the speed of a rotating `n`, as it is square
  /// to the axis of the rotation, and `any`.
  struct Bend {
    double square, any;
    double along(double speed_of_normal) const { return speed_of_normal * square + any; }
  };
  Bend bend(const Vec3& mid, const Vec3& half) const;
  double angle() const { return angle_; }  ///< in all, [0, pi]
  /// The longest path of a point of a body whose points are at most `reach` from its origin.
  double length(double reach) const { return along_.norm() + chord_speed_ + angle_ * (reach + centre_.norm()); }

 private:
  void follow_axis(const Vec3& revolution);
  Vec3 across_at(double angle) const;

  Motion motion_;
  Vec3 axis_ = Vec3::UnitZ();   // unit, world
  double angle_ = 0;            // [0, pi]
  Vec3 centre_ = Vec3::Zero();  // in the body's frame: the point whose displacement is given; for a screw the origin
  Vec3 along_, across_;         // components of the displacement along and across the axis; straight: all along
  Vec3 square_;                 // axis x across
  double chord_speed_ = 0;      // of the centre, across the axis
  // Points rotate about the centre or, of a body of revolution whose points follow its axis, about its point nearest to
  // the centre; of such a body, the axis in its frame, the cosine of its angle to that of the rotation, and a bound on
  // the acceleration of a point at unit distance, relative to angle^2.
  Vec3 about_ = Vec3::Zero();
  bool follows_axis_ = false;
  Vec3 revolution_ = Vec3::Zero();
  double cosine_ = 0, bend_ = 0;
};

}  // namespace tandem
