#pragma once
#include <cstdint>
#include <string_view>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// What is computed for a pair; nothing more is.
enum class Request : std::uint8_t {
  collide,   ///< yes or no, closed sets: touching counts
  distance,  ///< signed distance, witness points, normal
  contacts,  ///< the contact manifold
};
std::string_view name(Request request);

enum class Status : std::uint8_t {
  ok,
  inexact,  ///< the tolerance could not be reached; error_bound says what was
  /// Contacts with a mesh and NarrowPhaseOptions::mesh_bounds false: the depth is that of the deepest contact, and
  /// no bound on its error was asked for.
  unproven,
  /// NarrowPhaseOptions::limit was reached first: nothing is known, `collide` is false and error_bound infinite.
  stopped,
};

/// One point of a contact manifold, in world coordinates.
struct Contact {
  Vec3 point;        ///< midway between the two surfaces
  Vec3 normal;       ///< unit, from A to B: moving B by depth along it separates them here
  double depth = 0;  ///< >= 0 overlap; < 0 a gap within the margin asked for
  /// Names the features that touch; orders a pair's contacts. The same in the next step while the same face cuts the
  /// patch: of two that are flat to each other that may change, and the places stay. Who keeps something for a point
  /// from step to step should look for it by its place, too.
  std::uint32_t feature = 0;
};

struct PairAnswer {
  bool collide = false;
  /// All that is known is that they are farther apart than NarrowPhaseOptions::cutoff, which signed_distance is then;
  /// there are no points and no normal.
  bool farther = false;
  /// Set by Request::distance and Request::contacts (there: of the deepest contact; where the pair is farther apart
  /// than the margin, it may be the separation along any normal that says so, and the points not set; of two meshes
  /// that are apart, a lower bound on the gap, 0 if none is known, and there may be no normal).
  /// > 0 gap, < 0 minus the penetration depth, the length of the shortest translation that separates. With a mesh the
  /// depth is that of a translation which separates, the shortest that was found; error_bound says by how much the
  /// shortest of all may be shorter. Status::ok: it is known to be the shortest. Request::contacts tells the depth of
  /// the deepest contact, which is no deeper than a translation that was tried and separates; where several patches
  /// push along different normals, as of a floor and a wall, it may be less than needed: error_bound (inexact) says how
  /// far off it may be, either way. What separates something from a surface, or from a mesh that is not closed, may
  /// lead to either side of it.
  double signed_distance = 0;
  Vec3 point_a = Vec3::Zero();  ///< on A, world
  Vec3 point_b = Vec3::Zero();  ///< on B, world
  Vec3 normal = Vec3::Zero();   ///< unit, world, from A to B
  Status status = Status::ok;
  double error_bound = 0;  ///< metres, on signed_distance; 0 = rounding
};

/// What the last step learnt about a pair, kept by the caller and given back in the next: solvers that iterate begin
/// there and need fewer steps. It changes no answer beyond rounding. Zero: nothing is known.
struct WarmStart {
  Vec3 direction = Vec3::Zero();  ///< from A to B, in A's frame; any length
};

}  // namespace tandem
