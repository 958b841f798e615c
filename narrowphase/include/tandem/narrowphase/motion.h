// Rigid motions of a shape in unit time: screws, and straight motions with rotation.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// A rigid motion in unit time, at constant speed along and about a fixed axis (a screw, Chasles 1830), by the rotation
/// of at most half a turn that leads from one pose to the other.
struct Motion {
  Pose from, to;
  /// If given, not a screw: this point of the body, in its frame, moves on a straight line at constant speed, and the
  /// body rotates about it, as about the centre of mass in free flight.
  std::optional<Vec3> straight_of{};
};

/// Throws std::invalid_argument that names `what`, if a pose is not valid (pose.h) or straight_of is not finite or
/// beyond 1e30 m.
void require_valid(const Motion& motion, std::string_view what);

/// The pose at a time in [0, 1]; `from` and `to` at the ends, with the rotations nearest to theirs. Poses must be
/// valid.
Pose pose_at(const Motion& motion, double t);

/// The first contact of two moving bodies.
struct FirstTouch {
  double t = 0;                           ///< [0, 1]; 0 if they overlap or touch at the start
  Vec3 point = Vec3::Zero();              ///< midway between the surfaces at that time, world
  Vec3 normal = Vec3::Zero();             ///< unit, world, from A to B
  std::array<std::uint32_t, 2> feature{}; ///< of A and of B: the triangle of a mesh, cell of voxels, else 0
};

}  // namespace tandem
