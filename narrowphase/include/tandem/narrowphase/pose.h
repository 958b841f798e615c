// Vectors, matrices and poses.
#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string_view>

namespace tandem {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Quat = Eigen::Quaterniond;

/// A pose: world = rotation * v + translation. Triangles of meshes are exactly where these numbers put them; other
/// shapes take a rotation's transpose for its inverse, with an error proportional to the size and to the deviation from
/// an orthonormal matrix: by that requests may also differ from each other, and normals from unit length. Pass a
/// rotation of few digits through `orthonormalized` first, as scenes, SceneQueries and files do.
struct Pose {
  Mat3 rotation = Mat3::Identity();
  Vec3 translation = Vec3::Zero();

  Vec3 operator*(const Vec3& v) const { return rotation * v + translation; }
  /// A pose without rotation; metres.
  static Pose at(double x, double y, double z) { return {Mat3::Identity(), {x, y, z}}; }
  /// q need not be normalised, but must not be 0; t in metres.
  static Pose from(const Quat& q, const Vec3& t) { return {q.normalized().toRotationMatrix(), t}; }
};

/// Throws std::invalid_argument unless every number is finite, translations are at most 1e30, and the rotation has
/// determinant +1 and is orthonormal within 2e-6, for which six decimals are enough. `what` begins the message, as
/// "body 3".
void require_valid(const Pose& pose, std::string_view what);
/// True if require_valid accepts the pose.
bool is_valid(const Pose& pose);

/// The pose with the rotation nearest to a valid one's; the same bits if that is orthonormal to rounding (1e-14).
Pose orthonormalized(const Pose& pose);

}  // namespace tandem
