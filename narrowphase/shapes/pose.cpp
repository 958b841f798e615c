// Checks of poses, and rotations made orthonormal.
#include "tandem/narrowphase/pose.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "shapes/skewness.h"
#include "shapes/written.h"
#include "tolerances.h"

namespace tandem {

bool is_valid(const Pose& pose) {
  const Mat3& r = pose.rotation;
  const auto dot = [&](int i, int j) { return r(0, i) * r(0, j) + r(1, i) * r(1, j) + r(2, i) * r(2, j); };
  const auto near = [](double x, double to) -> int { return std::abs(x - to) <= tolerance::skew_allowed; };
  const Vec3& t = pose.translation;
  const double mixed = r(0, 2) * (r(1, 0) * r(2, 1) - r(2, 0) * r(1, 1)) +
                       r(1, 2) * (r(2, 0) * r(0, 1) - r(0, 0) * r(2, 1)) +
                       r(2, 2) * (r(0, 0) * r(1, 1) - r(1, 0) * r(0, 1));
  // In this form NaN fails; `&` of integers because branches would cost more.
  return (near(dot(0, 0), 1) & near(dot(1, 1), 1) & near(dot(2, 2), 1) & near(dot(0, 1), 0) & near(dot(0, 2), 0) &
          near(dot(1, 2), 0) & (mixed > 0) & (std::abs(t[0]) <= tolerance::longest_length) &
          (std::abs(t[1]) <= tolerance::longest_length) & (std::abs(t[2]) <= tolerance::longest_length)) != 0;
}

void require_valid(const Pose& pose, std::string_view what) {
  if (is_valid(pose)) return;
  const auto refuse = [&](const std::string& why) { throw std::invalid_argument(std::string(what) + ": " + why); };
  for (int i = 0; i < 3; ++i) {
    // In this form NaN fails, too.
    if (!(std::abs(pose.translation[i]) <= tolerance::longest_length))
      refuse("translation[" + std::to_string(i) + "] is " + written(pose.translation[i]) + "; it must be " +
             allowed_coordinate());
    for (int j = 0; j < 3; ++j)
      if (!std::isfinite(pose.rotation(i, j)))
        refuse("rotation(" + std::to_string(i) + ", " + std::to_string(j) + ") is " + written(pose.rotation(i, j)) +
               "; it must be finite");
  }
  const double off = skewness(pose.rotation);
  if (!(off <= tolerance::skew_allowed))
    refuse("rotation is off from orthonormal by " + written(off) + "; at most " + written(tolerance::skew_allowed) +
           " is allowed");
  if (!(pose.rotation.determinant() > 0)) refuse("rotation has determinant -1; it must be +1, not a reflection");
}

Pose orthonormalized(const Pose& pose) {
  Pose out = pose;
  if (skewness(pose.rotation) <= tolerance::orthonormal) return out;
  // The polar factor (Higham, Computing the Polar Decomposition, 1986): each iteration squares the error.
  for (int i = 0; i < 3; ++i) out.rotation *= 1.5 * Mat3::Identity() - 0.5 * out.rotation.transpose() * out.rotation;
  return out;
}

}  // namespace tandem
