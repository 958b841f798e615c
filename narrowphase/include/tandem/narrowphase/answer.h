// Requests for a pair, and answers: verdict, distance, contacts.
#pragma once
#include <cstdint>
#include <string_view>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// The request: what is computed for a pair, and no more.
enum class Request : std::uint8_t {
  collide,   ///< yes or no, closed sets: touching counts
  distance,  ///< signed distance, witness points, normal
  contacts,  ///< the contact manifold
};
std::string_view name(Request request);

enum class Status : std::uint8_t {
  ok,
  inexact,  ///< the tolerance could not be reached; error_bound gives what was
  /// Contacts with a mesh or voxels with NarrowPhaseOptions::mesh_bounds false: the depth is that of the deepest
  /// contact, without a bound on its error.
  unproven,
  /// NarrowPhaseOptions::limit was reached first: nothing is known, `collide` is false and error_bound infinite.
  stopped,
};

/// A point of a contact manifold, in world coordinates.
struct Contact {
  Vec3 point;        ///< midway between the two surfaces
  Vec3 normal;       ///< unit, from A to B: moving B by depth along it separates them here
  double depth = 0;  ///< >= 0 overlap; < 0 distance, within the margin asked for
  /// The features that touch, by which contacts are sorted; with voxels, feature / 64 is the cell, of two sets of
  /// voxels that of the one with more cells. The same in the next step while the same face clips the patch: for two
  /// equally aligned faces that may change, while the positions stay. A caller that keeps data for a point should match
  /// it by its position, too.
  std::uint32_t feature = 0;
};

struct PairAnswer {
  bool collide = false;
  /// True if they are farther apart than NarrowPhaseOptions::cutoff, which signed_distance then is; there are no points
  /// and no normal.
  bool farther = false;
  /// Set by Request::distance and Request::contacts. > 0: distance; < 0: minus the penetration depth, the length of the
  /// shortest translation that separates.
  ///
  /// With a mesh the depth is that of a translation that separates, the shortest that was found; error_bound says by
  /// how much the shortest of all may be shorter. Status::ok: it is known to be the shortest. A translation that
  /// separates something from a surface, or from a mesh that is not closed, may lead to either side of it.
  ///
  /// Request::contacts gives the depth of the deepest contact, which is no deeper than a translation that was tried and
  /// separates; where several patches push along different normals, such as those of a floor and a wall, it may be less
  /// than needed: error_bound (inexact) bounds the difference either way. For pairs farther apart than the margin it
  /// may be the separation along any normal, and the points are not set; for a mesh separated from another shape a
  /// lower bound on the distance, 0 if none is known, and there may be no normal.
  ///
  /// With voxels the same holds as with a mesh: the depth of the deepest cell is the lower bound, and the translation
  /// is searched along the normal of that cell, off all cells that touch, and along the axes of the grid.
  double signed_distance = 0;
  Vec3 point_a = Vec3::Zero();  ///< on A, world
  Vec3 point_b = Vec3::Zero();  ///< on B, world
  Vec3 normal = Vec3::Zero();   ///< unit, world, from A to B
  Status status = Status::ok;
  double error_bound = 0;  ///< metres, on signed_distance; 0 = rounding
};

/// The result of a pair in the last step, kept by the caller and passed back in the next: iterative solvers start from
/// it and need fewer steps. It changes no answer beyond rounding. Zero: no information.
struct WarmStart {
  Vec3 direction = Vec3::Zero();  ///< from A to B, in A's frame; any length
};

}  // namespace tandem
