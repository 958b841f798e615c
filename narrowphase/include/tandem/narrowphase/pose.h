#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string_view>

namespace tandem {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

/// world = rotation * v + translation. The rotation is used as given: exact answers are exact for these numbers.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  Vec3 operator*(const Vec3& v) const { return rotation * v + translation; }
  static Pose at(double x, double y, double z) { return {Mat3::Identity(), {x, y, z}}; }
  static Pose from(const Quat& q, const Vec3& t) { return {q.normalized().toRotationMatrix(), t}; }
};

/// Throws std::invalid_argument unless every number is finite, translations at most 1e30, and the rotation is one: orthonormal within 1e-6
/// and of determinant +1. `what` opens the message, e.g. "body 3".
void require_valid(const Pose& pose, std::string_view what);

}  // namespace tandem
