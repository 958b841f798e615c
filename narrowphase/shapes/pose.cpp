#include "tandem/narrowphase/pose.h"

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "tolerances.h"

namespace tandem {

namespace {

std::string written(double x) {
  std::ostringstream out;
  out.precision(17);
  out << x;
  return out.str();
}

double skewness(const Mat3& r) { return (r.transpose() * r - Mat3::Identity()).cwiseAbs().maxCoeff(); }

}  // namespace

bool is_valid(const Pose& pose) {
  // Written so that NaN fails; one in the rotation makes the determinant NaN.
  return pose.translation.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= 1e30 && pose.rotation.determinant() > 0 &&
         skewness(pose.rotation) <= tolerance::skew_allowed;
}

void require_valid(const Pose& pose, std::string_view what) {
  const auto refuse = [&](const std::string& why) { throw std::invalid_argument(std::string(what) + ": " + why); };
  for (int i = 0; i < 3; ++i) {
    // Written so that NaN fails too.
    if (!(std::abs(pose.translation[i]) <= 1e30))
      refuse("translation[" + std::to_string(i) + "] is " + written(pose.translation[i]) +
             "; it must be finite and at most 1e30 in size");
    for (int j = 0; j < 3; ++j)
      if (!std::isfinite(pose.rotation(i, j)))
        refuse("rotation(" + std::to_string(i) + ", " + std::to_string(j) + ") is " + written(pose.rotation(i, j)) +
               "; it must be finite");
  }
  const double off = skewness(pose.rotation);
  if (!(off <= tolerance::skew_allowed))
    refuse("rotation is off from orthonormal by " + written(off) + "; at most 2e-6 is allowed");
  if (!(pose.rotation.determinant() > 0)) refuse("rotation has determinant -1; it must be +1, not a reflection");
}

Pose orthonormalized(const Pose& pose) {
  Pose out = pose;
  if (skewness(pose.rotation) <= tolerance::orthonormal) return out;
  // The polar factor (Higham, Computing the Polar Decomposition, 1986): each round squares what is left.
  for (int i = 0; i < 3; ++i) out.rotation *= 1.5 * Mat3::Identity() - 0.5 * out.rotation.transpose() * out.rotation;
  return out;
}

}  // namespace tandem
