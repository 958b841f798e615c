// Boxes of moving shapes.
#include "scene/swept_boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scene/tolerances.h"

namespace tandem {
namespace {

/// Bounds in unit time on the motion of a point of the shape, metres, and on the change of its velocity.
struct Bound {
  double path, acceleration;
};

Bound bound_of(const Motion& motion, double reach) {
  const Mat3 turn = motion.to.rotation * motion.from.rotation.transpose();
  // Twice the sine of half the angle is the largest distance of a unit vector from its image.
  const double half_sine = std::min(1.0, (turn - Mat3::Identity()).norm() / std::sqrt(8.0));
  const double half = std::asin(half_sine), angle = 2 * half;
  if (motion.straight_of) {
    const double lever = reach + motion.straight_of->norm();
    return {(motion.to * *motion.straight_of - motion.from * *motion.straight_of).norm() + angle * lever,
            angle * angle * lever};
  }
  const double displacement = (motion.to.translation - motion.from.translation).norm();
  const double arc = half > 0 ? half / half_sine * displacement : displacement;
  return {arc + angle * reach, angle * (arc + angle * reach)};
}

constexpr float farthest = std::numeric_limits<float>::max();
constexpr Aabb everywhere{{-farthest, -farthest, -farthest}, {farthest, farthest, farthest}};

/// Rounded outward, and enlarged by `more`.
Aabb joined(const Bounds& a, const Bounds& b, double more) {
  Aabb box;
  for (int k = 0; k < 3; ++k) {
    box.lo[static_cast<std::size_t>(k)] = round_down(std::min(a.lo[k], b.lo[k]) - more);
    box.hi[static_cast<std::size_t>(k)] = round_up(std::max(a.hi[k], b.hi[k]) + more);
  }
  return box;
}

/// What poses and corners are rounded by: relative to the numbers that a corner is the sum of.
double rounding_of(const Motion& motion, double reach) {
  return tolerance::motion_rounding *
         (reach + std::max(motion.from.translation.norm(), motion.to.translation.norm()));
}

}  // namespace

double bulge(const Motion& motion, double reach) { return bound_of(motion, reach).acceleration / 8; }
double path_length(const Motion& motion, double reach) { return bound_of(motion, reach).path; }
double reach_of(const Shape& shape, const WorkLimit* limit) {
  const Bounds own = shape.bounds(Pose{}, limit);
  return own.lo.cwiseAbs().cwiseMax(own.hi.cwiseAbs()).norm();
}

double touch_share(const Shape& shape, double path) {
  return tolerance::touch_of_size * (shape.size() + shape.rounding()) + tolerance::touch_of_path * path;
}

Aabb swept_box(const Shape& shape, const Motion& motion) {
  if (!shape.is_bounded()) return everywhere;
  const Bounds from = shape.bounds(motion.from);
  const double reach = reach_of(shape), rounding = rounding_of(motion, reach);
  if (motion.from.translation == motion.to.translation && motion.from.rotation == motion.to.rotation)
    return joined(from, from, touch_share(shape) + rounding);
  const Bound bound = bound_of(motion, reach);
  return joined(from, shape.bounds(motion.to), bound.acceleration / 8 + touch_share(shape, bound.path) + rounding);
}

SweptBoxes::SweptBoxes(const Shape& shape, const Motion& motion, const WorkLimit* limit) {
  if (!shape.is_bounded()) {
    boxes_[size_++] = everywhere;
    return;
  }
  const Bounds own = shape.bounds(Pose{}, limit);
  const double reach = reach_of(shape, limit);
  const Bound bound = bound_of(motion, reach);
  const double length = std::max((own.hi - own.lo).maxCoeff(), bound.path / double{most});
  const auto stretches =
      static_cast<std::size_t>(length > 0 ? std::clamp(std::ceil(bound.path / length), 1.0, double{most}) : 1);
  const double dt = 1 / static_cast<double>(stretches);
  const double more =
      bound.acceleration * dt * dt / 8 + touch_share(shape, bound.path) + rounding_of(motion, reach);
  Bounds last = shape.bounds(pose_at(motion, 0));
  for (std::size_t i = 1; i <= stretches; ++i) {
    const Bounds next = shape.bounds(pose_at(motion, static_cast<double>(i) / static_cast<double>(stretches)));
    boxes_[size_++] = joined(last, next, more);
    last = next;
  }
}

}  // namespace tandem
