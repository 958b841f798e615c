#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string_view>

namespace tandem {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

/// world = rotation * v + translation. Triangles of meshes stand exactly where these numbers put them; all else takes a
/// rotation's transpose for its inverse, and is off by as much of the size as that is not orthonormal.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  Vec3 operator*(const Vec3& v) const { return rotation * v + translation; }
  /// Not turned; metres.
  static Pose at(double x, double y, double z) { return {Mat3::Identity(), {x, y, z}}; }
  /// q need not be normalised, but not be 0; t in metres.
  static Pose from(const Quat& q, const Vec3& t) { return {q.normalized().toRotationMatrix(), t}; }
};

/// Throws std::invalid_argument unless every number is finite, translations at most 1e30, and the rotation is one: of
/// determinant +1 and orthonormal within 2e-6, so that six decimals are enough. `what` opens the message, "body 3".
void require_valid(const Pose& pose, std::string_view what);
/// Whether require_valid takes it.
bool is_valid(const Pose& pose);

/// The pose with the rotation nearest to a valid one's; the same bits where that is orthonormal to rounding (1e-14).
Pose orthonormalized(const Pose& pose);

}  // namespace tandem
