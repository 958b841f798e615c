// Screw motions: poses and bounds on speeds.
#include "shapes/screw_path.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {

ScrewPath::ScrewPath(const Motion& motion, std::optional<Vec3> revolution)
    : motion_{orthonormalized(motion.from), orthonormalized(motion.to)} {
  const Quat turn(Mat3(motion_.to.rotation * motion_.from.rotation.transpose()));
  const double sine = turn.vec().norm();
  if (sine > 0) {
    axis_ = (turn.w() < 0 ? -1.0 : 1.0) / sine * turn.vec();
    angle_ = 2 * std::atan2(sine, std::abs(turn.w()));
  }
  if (motion.straight_of) centre_ = about_ = *motion.straight_of;
  if (revolution) follow_axis(*revolution);
  if (motion.straight_of) {
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

// The axis u of the body has a constant angle to that of the rotation, w. With the angular velocity w' = w - (w . u) u
// it moves in the same way, but the body does not spin; a point at distance r of the axis' point then has at most the
// acceleration (|w'|^2 + |w . u| |w x u|) r.
void ScrewPath::follow_axis(const Vec3& revolution) {
  const Vec3 world = motion_.from.rotation * revolution;
  const double cosine = axis_.dot(world), sine = axis_.cross(world).norm(), bend = sine * (sine + std::abs(cosine));
  follows_axis_ = bend < 0.5;
  if (!follows_axis_) return;
  revolution_ = revolution;
  about_ = revolution.dot(centre_) * revolution;
  cosine_ = cosine;
  bend_ = bend;
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

ScrewPath::Speed ScrewPath::speed_along(const Vec3& n, const Pose& pose, double t, const Vec3& mid,
                                        const Vec3& half) const {
  const double half_angle = angle_ / 2;
  const double scale = half_angle > 0 ? half_angle / std::sin(half_angle) : 1.0;
  const double of_centre = n.dot(along_ + scale * across_at((t - 0.5) * angle_));
  if (angle_ == 0) return {of_centre, 0};
  // n . (omega x r) = (n x omega) . r, maximised over the box.
  const Vec3 turning = n.cross(angle_ * axis_), lever = pose.rotation.transpose() * turning;
  const double of_normal = turning.norm();
  if (!follows_axis_) return {of_centre + lever.dot(mid - about_) + lever.cwiseAbs().dot(half), of_normal};
  const Vec3 of_axis = lever - angle_ * cosine_ * (pose.rotation.transpose() * n).cross(revolution_);
  return {of_centre + lever.dot(about_ - centre_) + of_axis.dot(mid - about_) + of_axis.cwiseAbs().dot(half),
          of_normal};
}

double ScrewPath::fastest(const Vec3& mid, const Vec3& half) const {
  return along_.norm() + chord_speed_ + angle_ * ((about_ - centre_).norm() + (mid - about_).norm() + half.norm());
}

// The centre, and what rotates about it with the body, are accelerated square to the axis.
ScrewPath::Bend ScrewPath::bend(const Vec3& mid, const Vec3& half) const {
  if (angle_ == 0) return {0, 0};
  const double reach = (mid - about_).norm() + half.norm();
  if (!follows_axis_) return {chord_speed_ + angle_ * reach, 0};
  return {chord_speed_ + angle_ * (about_ - centre_).norm(), angle_ * angle_ * bend_ * reach};
}

void require_valid(const Motion& motion, std::string_view what) {
  const std::string name(what);
  require_valid(motion.from, name + ": from");
  require_valid(motion.to, name + ": to");
  if (!motion.straight_of) return;
  for (int i = 0; i < 3; ++i) {
    const double x = (*motion.straight_of)[i];
    if (!(std::abs(x) <= tolerance::longest_length))
      throw std::invalid_argument(name + ": straight_of[" + std::to_string(i) + "] is " + written(x) + "; it must be " +
                                  allowed_coordinate());
  }
}

Pose pose_at(const Motion& motion, double t) { return ScrewPath(motion).at(t); }

}  // namespace tandem
