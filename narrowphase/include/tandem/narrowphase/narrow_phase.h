#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tandem/narrowphase/shape.h"

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
  /// Contacts of two meshes with NarrowPhaseOptions::mesh_bounds false: the depth is that of the deepest contact, and no
  /// bound on its error was asked for.
  unproven,
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
  /// Set by Request::distance and Request::contacts (there: of the deepest contact; where the pair is farther apart
  /// than the margin, it may be the separation along any normal that says so, and the points not set; of two meshes
  /// that are apart, a lower bound on the gap, 0 if none is known, and there may be no normal).
  /// > 0 gap, < 0 minus the penetration depth, the length of the shortest translation that separates. With a mesh the
  /// depth is that of a translation which separates, the shortest that was found; error_bound says by how much the
  /// shortest of all may be shorter. Status::ok: it is known to be the shortest. Request::contacts tells the depth of
  /// the deepest contact, which is no deeper than a translation that was tried and separates; where several patches push
  /// along different normals, as of a floor and a wall, it may be less than needed: error_bound (inexact) says how far
  /// off it may be, either way. What separates something from a surface, or from a mesh that is not closed, may lead to
  /// either side of it.
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

/// Two shapes where they are, none of them owned.
struct PlacedPair {
  const Shape* a;
  const Pose* pose_a;
  const Shape* b;
  const Pose* pose_b;
};

/// Runs part(0) ... part(parts - 1), on one thread or several, and returns when all are done; throws what a part threw.
using PartRunner = std::function<void(std::size_t parts, const std::function<void(std::size_t)>& part)>;

struct NarrowPhaseOptions {
  /// Error the user accepts, relative to the bodies' size, [0, 0.1]; 0: to rounding. The cheapest solver of the
  /// table that meets it is taken.
  double tolerance = 0;
  /// Request::contacts also reports gaps up to this, as negative depths (metres, finite, >= 0). Not used between two
  /// meshes, which report what intersects.
  double margin = 0;
  /// Forces the solver of that name (`solvers()` lists them) wherever it covers the pair; empty: the table's choice.
  std::string solver{};
  /// Shares the work on a pair of very large meshes, by subtrees; the answer does not depend on it. Empty: the caller.
  PartRunner parts{};
  /// Request::contacts says of two meshes that are apart how far at least. False: it says 0, which saves up to a
  /// twelfth of the time of those that nearly touch.
  bool mesh_gaps = true;
  /// Request::contacts proves of two meshes that collide that moving by the deepest contact separates them, replaces it
  /// where that is not so, and bounds the error. False: Status::unproven; saves a yes/no and some distances of points a
  /// pair, and hundredfold that of meshes deep in each other.
  bool mesh_bounds = true;
};

/// One row of the solver table.
struct SolverInfo {
  std::string_view name;         ///< "closed", "sat", "gjk", "fcl", "libccd", "bvh", ...
  std::string_view description;  ///< one line, with its source
};

/// One row of the table from which a tolerance chooses: what a solver costs on a pair of kinds, and how far off it was
/// at most. Measured over separated, near, shallow, deep and hard pairs alike.
struct SolverRow {
  ShapeKind a, b;  ///< unordered
  Request request;
  std::string_view solver;  ///< by its name in `solvers()`
  double tolerance;         ///< that it is run with, relative to the bodies' size; 0: to rounding
  double nanoseconds;       ///< a query, mean of the classes; on one machine: good for comparing rows only
  double error;  ///< largest, of the signed distance (collide: of the gap it took for a touch, or a touch for
                 ///< a gap), relative to size
};

/// The dispatcher (paper, section 3.3): a table over the two shapes' kinds. Every unordered pair of kinds has a
/// solver. Const and safe from any number of threads at once; the answer depends on nothing but the arguments.
class NarrowPhase {
 public:
  /// Throws std::invalid_argument for a bad option (an unknown solver name is answered with the list).
  explicit NarrowPhase(NarrowPhaseOptions options = {});

  static const std::vector<SolverInfo>& solvers();

  /// The measured rows, cheapest first for each pair of kinds and request. Pairs without one have one solver only.
  static std::span<const SolverRow> table();
  /// The row by which such a pair is solved: of those whose error the tolerance admits the cheapest, else the solver
  /// that is right to rounding (whose row may be unmeasured: nanoseconds and error 0).
  SolverRow solver_for(ShapeKind a, ShapeKind b, Request request) const;

  /// Empty if the pair can be solved; else why not, naming both kinds.
  std::string refuses(const Shape& a, const Shape& b, Request request) const;

  /// Solves one pair. Poses must be valid. With Request::contacts the manifold is appended to `contacts`, in
  /// canonical order (by feature). Bounded work, no NaN; swapping A and B swaps the answer. `warm` is read and written
  /// where the pair's solver iterates, and left alone where it does not.
  PairAnswer solve(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                   std::vector<Contact>* contacts = nullptr, WarmStart* warm = nullptr) const;

  /// Sets apart[i] (else clears it) where pair i is known to be farther apart than the margin: found for several pairs
  /// at a time, so that `solve` need not be asked where answers of pairs that far apart are not wanted. Never set where
  /// `solve` finds less than the margin; not set where it is not known. Knows two boxes only. Both spans one length.
  void mark_apart(std::span<const PlacedPair> pairs, std::span<std::uint8_t> apart) const;

  /// All intersecting pairs of triangles [i of A, j of B], sorted; both shapes a triangle or a mesh (else throws
  /// std::invalid_argument). Closed triangles; exact for the real numbers R v + t.
  std::vector<std::array<std::uint32_t, 2>> intersecting_triangles(const Shape& a, const Pose& pose_a, const Shape& b,
                                                                   const Pose& pose_b) const;

  /// First time in [0, tmax] at which they touch when A and B translate with constant velocities; empty if never.
  /// Conservative advancement on the signed distance; never late by more than 1e-12 of the path.
  std::optional<double> time_of_impact(const Shape& a, const Pose& pose_a, const Vec3& velocity_a, const Shape& b,
                                       const Pose& pose_b, const Vec3& velocity_b, double tmax) const;

 private:
  NarrowPhaseOptions options_;
};

}  // namespace tandem
