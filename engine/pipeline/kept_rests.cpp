// Contact caching over steps: which bodies rest.
#include <limits>

#include "pipeline/kept_contacts.h"
#include "scene/tolerances.h"

namespace tandem {
namespace {

using tolerance::rest_share;

/// The sum of squares of the difference of two matrices.
double squared_distance(const Mat3& now, const Mat3& then) {
  using Eight = Eigen::Map<const Eigen::Array<double, 8, 1>>;  // two at a time
  const double last = now(2, 2) - then(2, 2);
  return (Eight(now.data()) - Eight(then.data())).square().sum() + last * last;
}

/// Whether all points of a body are within `reach` of where they were when its rest began.
bool rests(const Pose& pose, const Vec3& place, const Mat3& rotation, const KeptContacts::Ball& ball, double reach) {
  const Vec3 moved = pose.translation - place;
  if (reach == 0) return moved.isZero(0) && pose.rotation == rotation;
  const double far = tolerance::squared_reach * reach * reach;
  if (ball.is_round) return 2 * moved.squaredNorm() <= far;
  const Vec3 centre_moved = ball.is_centred ? moved : moved + (pose.rotation - rotation) * ball.centre;
  // The spectral norm of a difference of rotations is its Frobenius norm over the root of 2. (x + y)^2 <= 2 (x^2 +
  // y^2).
  const double turned = squared_distance(pose.rotation, rotation) * (ball.radius * ball.radius);
  return 2 * centre_moved.squaredNorm() + turned <= far;
}

}  // namespace

void KeptContacts::update_rests(std::size_t first, std::span<std::uint8_t> changed) {
  // Local pointers: to the compiler, a written byte might alias any member.
  const auto* const shape_of = scene_->shape_indices().data();
  const Pose* const poses = scene_->poses().data();
  const Ball* const balls = balls_.data();
  const Vec3* const places = anchor_places_.data();
  const Mat3* const rotations = anchor_rotations_.data();
  const double* const reaches = reach_.data();
  const std::uint8_t* const arrived = arrived_.empty() ? nullptr : arrived_.data();
  const bool same_bodies = same_bodies_;
  bool any_moved = false;
  for (std::size_t k = 0; k < changed.size(); ++k) {
    if (changed[k] == 0) continue;
    const std::size_t i = first + k;
    const Ball& ball = balls[shape_of[i]];
    if ((same_bodies || is_as_it_was(i, ball)) && rests(poses[i], places[i], rotations[i], ball, reaches[i])) {
      changed[k] = arrived == nullptr ? 0 : arrived[i];
    } else {
      end_rest(i, ball);
      any_moved = true;
    }
  }
  if (any_moved) any_moved_.store(true, std::memory_order_relaxed);
}

std::uint64_t KeptContacts::shape_now(std::size_t body, const Ball& ball) const {
  return scene_->alive(static_cast<std::uint32_t>(body)) ? ball.shape : 0;
}

double KeptContacts::reach_now(std::size_t body, const Ball& ball) const {
  const bool is_endless = !(ball.radius < std::numeric_limits<double>::infinity());
  return scene_->is_static()[body] != 0 || is_endless ? 0 : rest_share * ball.allowed;
}

/// But for its pose. A place without a body is not: whoever reads it for the first time must learn that it is empty.
bool KeptContacts::is_as_it_was(std::size_t body, const Ball& ball) const {
  const std::uint64_t shape = shape_now(body, ball);
  return shape != 0 && shape == body_shapes_[body] && reach_now(body, ball) == reach_[body];
}

void KeptContacts::end_rest(std::size_t body, const Ball& ball) {
  const Pose& pose = scene_->poses()[body];
  since_[body] = step_;
  anchor_places_[body] = pose.translation;
  anchor_rotations_[body] = pose.rotation;
  const std::uint64_t shape = shape_now(body, ball);
  const double reach = reach_now(body, ball);
  if (shape == body_shapes_[body] && reach == reach_[body]) return;
  body_shapes_[body] = shape;
  reach_[body] = reach;
  changed_[body] = step_;
}

}  // namespace tandem
