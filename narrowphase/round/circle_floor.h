// A lower bound on a body's support over an interval of a circle of directions.
#pragma once
#include <algorithm>
#include <utility>

#include "shapes/round_body.h"
#include "tolerances.h"

namespace tandem {

/// A direction on a circle: its component in the circle's plane, unit, and the point that supports it.
struct Sample {
  Vec3 out, p;
};

/// An interval of directions on a circle, counterclockwise, less than half a turn.
struct Span {
  Sample first, last;
};

/// A lower bound on a body's support over an interval of a circle of directions, by the body's circles: r sqrt(1 - (n .
/// axis)^2) is concave in n . axis, so it is not below its chord over the interval, which is linear in n. For two
/// bodies with (almost) parallel axes the support is nearly constant all around, and bounds by points would need as
/// many points as the interval is short.
class CircleFloor {
 public:
  explicit CircleFloor(const Circle& circle) : circle_(circle) {}
  CircleFloor(const RoundBody& body, const Circle& circle, const Vec3& offset) : circle_(circle) {
    if (!body.has_circle()) return;
    axis_ = body.axis(), radius_ = body.radius();
    for (int piece = 0; piece < 2; ++piece)
      if (body.is_circle(piece)) centre_[count_++] = body.circle_centre(piece) + offset;
  }

  /// The bound; minus infinity if there is none.
  double over(const Span& span) const {
    double most = -infinity;
    const double lift = circle_.height, radius = circle_.radius;
    const auto spread = [&](const Vec3& v) {  // the range of v . n
      const Vec3 flat = v - v.dot(circle_.axis) * circle_.axis;
      const double length = flat.norm(), at = lift * v.dot(circle_.axis);
      const double ends[2] = {radius * flat.dot(span.first.out), radius * flat.dot(span.last.out)};
      double low = std::min(ends[0], ends[1]), high = std::max(ends[0], ends[1]);
      if (within(span, flat)) high = radius * length;
      if (within(span, -flat)) low = -radius * length;
      return std::pair{at + low, at + high};
    };
    if (count_ == 0) return most;
    auto [low, high] = spread(axis_);
    low = std::clamp(low, -1.0, 1.0), high = std::clamp(high, -1.0, 1.0);
    const double at_low = std::sqrt(1 - low * low), at_high = std::sqrt(1 - high * high);
    const double slope = at_low + at_high > 0 ? -(low + high) / (at_low + at_high) : 0.0;
    const double rounding = 4 * epsilon / std::max(std::min(at_low, at_high), tolerance::never_zero_sine);
    for (int i = 0; i < count_; ++i)
      most = std::max(most,
                      spread(centre_[i] + radius_ * slope * axis_).first + radius_ * (at_low - slope * low - rounding));
    return most;
  }

 private:
  bool within(const Span& span, const Vec3& v) const {
    return circle_.axis.dot(span.first.out.cross(v)) > 0 && circle_.axis.dot(v.cross(span.last.out)) > 0;
  }

  const Circle& circle_;
  Vec3 axis_ = Vec3::Zero(), centre_[2];
  double radius_ = 0;
  int count_ = 0;
};

}  // namespace tandem
