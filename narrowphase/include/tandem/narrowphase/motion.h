#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// A rigid motion in unit time, at constant speed along and about a fixed axis (a screw, Chasles 1830), by the turn of
/// at most half a circle that leads from one pose to the other.
struct Motion {
  Pose from, to;
  /// Where given, no screw: this point of the body, in its frame, goes straight and evenly, and the body turns about
  /// it. So does the centre of mass of a body in free flight.
  std::optional<Vec3> straight_of{};
};

/// Throws std::invalid_argument that names `what`, where a pose is not valid (pose.h) or straight_of is not finite or
/// beyond 1e30 m.
void require_valid(const Motion& motion, std::string_view what);

/// Where the body is at a time in [0, 1]; `from` and `to` at the ends, with the rotations nearest to theirs. Of valid
/// poses.
Pose pose_at(const Motion& motion, double t);

/// The first touch of two that move.
struct FirstTouch {
  double t = 0;                           ///< [0, 1]; 0 where they overlap or touch at the start
  Vec3 point = Vec3::Zero();              ///< midway between the surfaces then, world
  Vec3 normal = Vec3::Zero();             ///< unit, world, from A to B
  std::array<std::uint32_t, 2> feature{}; ///< of A and of B: the triangle of a mesh, else 0
};

}  // namespace tandem
