// Screw motions: poses and bounds on speeds.
#include "shapes/screw_path.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {

ScrewPath::ScrewPath(const Motion& motion) : motion_{orthonormalized(motion.from), orthonormalized(motion.to)} {
  const Quat turn(Mat3(motion_.to.rotation * motion_.from.rotation.transpose()));
  const double sine = turn.vec().norm();
  if (sine > 0) {
    axis_ = (turn.w() < 0 ? -1.0 : 1.0) / sine * turn.vec();
    angle_ = 2 * std::atan2(sine, std::abs(turn.w()));
  }
  if (motion.straight_of) {
    centre_ = *motion.straight_of;
    along_ = motion_.to * centre_ - motion_.from * centre_;
    across_ = square_ = Vec3::Zero();
    return;
  }
  const Vec3 displacement = motion.to.translation - motion.from.translation;
  along_ = axis_.dot(displacement) * axis_;
  across_ = displacement - along_;
  square_ = axis_.cross(across_);
  const double half = angle_ / 2;
  chord_speed_ = (half > 0 ? half / std::sin(half) : 1.0) * across_.norm();
}

// The component across the axis, rotated.
Vec3 ScrewPath::across_at(double angle) const { return std::cos(angle) * across_ + std::sin(angle) * square_; }

Pose ScrewPath::at(double t) const {
  if (t <= 0) return motion_.from;
  if (t >= 1) return motion_.to;
  const double half = angle_ / 2;
  const double ratio = half > 0 ? std::sin(t * half) / std::sin(half) : t;
  Pose pose;
  const double s = std::sin(t * half);
  Mat3 cross;
  cross << 0, -axis_[2], axis_[1], axis_[2], 0, -axis_[0], -axis_[1], axis_[0], 0;
  const Mat3 turn = Mat3::Identity() + std::sin(t * angle_) * cross + 2 * s * s * (cross * cross);  // Rodrigues 1840
  pose.rotation = turn * motion_.from.rotation;
  pose.translation = motion_.from * centre_ + t * along_ + ratio * across_at((t - 1) * half) - pose.rotation * centre_;
  return pose;
}

double ScrewPath::speed_along(const Vec3& n, const Pose& pose, double t, const Vec3& mid, const Vec3& half) const {
  const double half_angle = angle_ / 2;
  const double scale = half_angle > 0 ? half_angle / std::sin(half_angle) : 1.0;
  const Vec3 velocity = along_ + scale * across_at((t - 0.5) * angle_);
  if (angle_ == 0) return n.dot(velocity);
  // n . (omega x r) = (n x omega) . r, maximised over the box.
  const Vec3 lever = pose.rotation.transpose() * n.cross(angle_ * axis_);
  return n.dot(velocity) + lever.dot(mid - centre_) + lever.cwiseAbs().dot(half);
}

double ScrewPath::acceleration(const Vec3& mid, const Vec3& half) const {
  return angle_ == 0 ? 0 : angle_ * (chord_speed_ + angle_ * ((mid - centre_).norm() + half.norm()));
}

void require_valid(const Motion& motion, std::string_view what) {
  const std::string name(what);
  require_valid(motion.from, name + ": from");
  require_valid(motion.to, name + ": to");
  if (!motion.straight_of) return;
  for (int i = 0; i < 3; ++i) {
    const double x = (*motion.straight_of)[i];
    if (!(std::abs(x) <= tolerance::longest_length))
      throw std::invalid_argument(name + ": straight_of[" + std::to_string(i) + "] is " + written(x) +
                                  "; it must be " + allowed_coordinate());
  }
}

Pose pose_at(const Motion& motion, double t) { return ScrewPath(motion).at(t); }

}  // namespace tandem
