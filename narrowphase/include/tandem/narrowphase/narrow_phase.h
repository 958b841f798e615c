// The narrow phase: queries of two shapes with poses.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/motion.h"
#include "tandem/narrowphase/options.h"
#include "tandem/narrowphase/shape.h"
#include "tandem/narrowphase/solver_info.h"

namespace tandem {

/// The dispatcher of Avril, Gouranton and Arnaldi (ICAT 2010, section 3.3): a table over the two shapes' kinds. Every
/// unordered pair of kinds has a solver except half-spaces and planes with each other, whose distance and contacts are
/// refused; `refuses` tells beforehand. Const and safe from any number of threads at once; the answer depends only on
/// the arguments.
class NarrowPhase {
 public:
  /// Throws std::invalid_argument for a bad option (for an unknown solver name, with the list of solvers).
  explicit NarrowPhase(NarrowPhaseOptions options = {});

  static const std::vector<SolverInfo>& solvers();

  /// The measured rows, cheapest first for each pair of kinds and request. A pair without rows has one solver only.
  static std::span<const SolverRow> table();
  /// The row by which such a pair is solved: the cheapest whose error is within the tolerance, else the solver that is
  /// right to rounding (whose row may be unmeasured: nanoseconds and error 0).
  SolverRow solver_for(ShapeKind a, ShapeKind b, Request request) const;

  /// The reason why the pair cannot be solved, naming both kinds; empty if it can.
  std::string refuses(const Shape& a, const Shape& b, Request request) const;

  /// Solves a pair. Throws std::invalid_argument for a pair that `refuses` names. Poses must be valid, which is not
  /// checked (require_valid). With Request::contacts the manifold is appended to `contacts` (if not null), in canonical
  /// order (by feature). Bounded work, no NaN; swapping A and B swaps the answer. If NarrowPhaseOptions::limit is
  /// reached first, the answer is Status::stopped and no contact is appended. `warm` is read and written if the pair's
  /// solver iterates, and unchanged otherwise.
  PairAnswer solve(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, Request request,
                   std::vector<Contact>* contacts = nullptr, WarmStart* warm = nullptr) const;

  /// Solves Request::distance with a cut-off of its own (metres, >= 0, infinity is allowed; the smaller of this and the
  /// option counts), for searches of the nearest of many, whose limit shrinks. Throws std::invalid_argument for a
  /// negative or NaN cut-off, and as `solve`.
  PairAnswer distance_within(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                             double cutoff) const;

  /// Sets apart[i] (else clears it) if pair i is known to be farther apart than the margin, several pairs at a time, so
  /// that `solve` need not be called for such pairs. Never set where `solve` finds less than the margin; not set where
  /// it is not known. Tests pairs of boxes only. Both spans have one length.
  void mark_apart(std::span<const PlacedPair> pairs, std::span<std::uint8_t> apart) const;

  /// All intersecting pairs of triangles [i of A, j of B], sorted; both shapes a triangle or a mesh (else throws
  /// std::invalid_argument). Closed triangles; exact for the real numbers R v + t. Throws WorkStopped (work_limit.h) if
  /// NarrowPhaseOptions::limit is reached first.
  std::vector<std::array<std::uint32_t, 2>> intersecting_triangles(const Shape& a, const Pose& pose_a, const Shape& b,
                                                                   const Pose& pose_b) const;

  /// The first time in [0, tmax] (s) at which they touch when A and B translate with constant velocities (m/s, finite);
  /// empty if never. By conservative advancement on the signed distance; late by at most 1e-12 of the path, early where
  /// they come as near as 1e-14 of their sizes and coordinates. Throws std::invalid_argument for velocities that are
  /// not finite, a tmax that is not finite and >= 0, and pairs whose distance is refused; WorkStopped as above. Poses
  /// must be valid.
  std::optional<double> time_of_impact(const Shape& a, const Pose& pose_a, const Vec3& velocity_a, const Shape& b,
                                       const Pose& pose_b, const Vec3& velocity_b, double tmax) const;

  /// The first contact of two bodies on motions that may rotate; empty if there is none. Never missed, and late at most
  /// by rounding; early where they come as near as 1e-10 of the path, or, if both turn about an axis many sizes away,
  /// as 2e-7 of it. By conservative advancement with a bound on the speed of each body's points along the normal
  /// (Mirtich 1996; Zhang, Lee and Kim, "Interactive continuous collision detection for non-convex polyhedra", 2006),
  /// for meshes by their hierarchies. Poses must be valid. Throws std::invalid_argument for pairs whose distance is
  /// refused; WorkStopped as above.
  std::optional<FirstTouch> time_of_impact(const Shape& a, const Motion& motion_a, const Shape& b,
                                      const Motion& motion_b) const;

 private:
  NarrowPhaseOptions options_;
};

}  // namespace tandem
