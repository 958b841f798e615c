#include "queries/swept_boxes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tandem {
namespace {

/// Metres a point of the shape moves at most, and how much its velocity changes, both in unit time.
struct Bound {
  double path, acceleration;
};

Bound bound_of(const Motion& motion, double reach) {
  const double displacement = (motion.to.translation - motion.from.translation).norm();
  const Mat3 turn = motion.to.rotation * motion.from.rotation.transpose();
  // Twice the sine of half the angle is the largest distance over all unit vectors from their images.
  const double half_sine = std::min(1.0, (turn - Mat3::Identity()).norm() / std::sqrt(8.0));
  const double half = std::asin(half_sine), angle = 2 * half;
  const double arc = half > 0 ? half / half_sine * displacement : displacement;
  return {arc + angle * reach, angle * (arc + angle * reach)};
}

}  // namespace

double bulge(const Motion& motion, double reach) { return bound_of(motion, reach).acceleration / 8; }

SweptBoxes::SweptBoxes(const Shape& shape, const Motion& motion) {
  if (!shape.is_bounded()) {
    constexpr float all = std::numeric_limits<float>::max();
    boxes_.push_back({{-all, -all, -all}, {all, all, all}});
    return;
  }
  const Bounds own = shape.bounds(Pose{});
  const double reach = own.lo.cwiseAbs().cwiseMax(own.hi.cwiseAbs()).norm();
  const Bound bound = bound_of(motion, reach);
  constexpr double most_stretches = 64;
  const double length = std::max((own.hi - own.lo).maxCoeff(), bound.path / most_stretches);
  const auto stretches = static_cast<std::size_t>(length > 0 ? std::clamp(std::ceil(bound.path / length), 1.0, most_stretches) : 1);
  const double dt = 1 / static_cast<double>(stretches);
  const double bulge = bound.acceleration * dt * dt / 8;
  Bounds last = shape.bounds(pose_at(motion, 0));
  for (std::size_t i = 1; i <= stretches; ++i) {
    const Bounds next = shape.bounds(pose_at(motion, static_cast<double>(i) / static_cast<double>(stretches)));
    Aabb box;
    for (int k = 0; k < 3; ++k) {
      box.lo[static_cast<std::size_t>(k)] = round_down(std::min(last.lo[k], next.lo[k]) - bulge);
      box.hi[static_cast<std::size_t>(k)] = round_up(std::max(last.hi[k], next.hi[k]) + bulge);
    }
    boxes_.push_back(box);
    last = next;
  }
}

}  // namespace tandem
