// The search for the shortest translation that separates two bodies of which at least one is a mesh: methods that
// shorten the known translation or raise the lower bound. Which methods are used for two bodies, in which order, is the
// policy of their solver.
#pragma once
#include <span>
#include <vector>

#include "meshes/traversal/least_translation.h"
#include "tandem/narrowphase/answer.h"
#include "tolerances.h"

namespace tandem {

/// The known bounds on the shortest translation of B that separates.
struct Separation {
  double certain = 0;        ///< no shorter translation separates
  double length = infinity;  ///< a translation of this length separates, along the normal
  Vec3 normal = Vec3::UnitZ();
  Vec3 point = Vec3::Zero();  ///< midway between the points that separate last
};

/// Parameters of the search that depend on the kind of pair, whose queries differ in cost.
struct SearchEffort {
  double least_reach;  ///< of constraints that bound the length from below, relative to it
  int rounds;          ///< number of iterations with planes about the end of the translation
  double plane_reach;  ///< of planes about the end of a translation, relative to the size; infinity: its length
  double margin;       ///< distance by which a translation ends beyond the obstacle, in `slack`; 0: on it
  double plane_slack;  ///< precision of the planes, in `slack`
  bool trust_planes;   ///< a translation by planes is tested only at the end
};

/// Two overlapping bodies, as queries of the search. B moves, in axes chosen by the pair.
class OverlappingPair {
 public:
  OverlappingPair(double size, const SearchEffort& effort) : size(size), effort(effort) {}
  virtual ~OverlappingPair() = default;

  const double size;  ///< of both, metres
  const double slack = tolerance::place_rounding * size;
  const double enough = tolerance::translation_slack * size;  ///< over the lower bound counts as the shortest, metres
  const SearchEffort effort;

  /// Of a translation off all that touches: far less than what counts as the shortest, and no less than rounding.
  OffPrecision off_precision() const { return {slack / 4, slack / 16, slack, tolerance::alike * size}; }

  /// A slightly longer translation: the given one may end touching both the obstacle that B leaves and the next, with
  /// both reported as separated because of rounding; or in a gap exactly as wide as B.
  Vec3 farther(const Vec3& move) const;

  /// True if the two collide with B translated.
  virtual bool collide(const Vec3& move) const = 0;

  /// True if a translation separates, and also a slightly longer one.
  virtual bool is_free(const Vec3& move) const = 0;

  /// The length of a translation along a direction (unit) that separates; infinity if it is not less than known.length.
  virtual double free_length(const Vec3& direction, const Separation& known) const = 0;

  /// Adds constraints from intersecting features with B translated by `at`, where they collide. False: none is new, or
  /// no translation satisfies them all.
  virtual bool add_constraints(const Vec3& at, LocalConstraints& constraints) const = 0;

  /// Planes that separate all of B, translated by `at`, from the parts of A less than `reach` away, as constraints: a
  /// translation that satisfies them and ends within that distance of `at` separates. False: two parts touch, or it
  /// would take too much work.
  virtual bool separating_planes(const Vec3& at, double reach, std::vector<Constraint>& planes) = 0;
};

class SeparationSearch {
 public:
  SeparationSearch(OverlappingPair& pair, const Separation& known)
      : known(known), pair_(pair), constraints_(pair.slack) {}

  Separation known;

  /// True if the known translation is the shortest, to the required precision.
  bool is_shortest() const { return known.length <= known.certain + pair_.enough; }

  /// Takes a translation that separates as the known one.
  void take(const Vec3& translation);

  /// Tries a direction (unit; zero: none).
  void along(const Vec3& direction);

  /// Tries the shortest translation that satisfies constraints.
  void beyond(std::span<const Constraint> constraints);

  /// Tries the shortest translation beyond all obstacles here, then beyond those at its end, and so on.
  void beyond_obstacles();

  /// Shortens the known translation by the planes about its end, to one than which no translation nearby is shorter.
  void shorten();

  /// Raises the lower bound by the obstacles that B meets shortly before the end of the known translation.
  void confirm();

  /// The length, its status and the normal, in the pair's axes; without points.
  PairAnswer answer() const;

 private:
  void raise_certain();

  OverlappingPair& pair_;
  LocalConstraints constraints_;
};

}  // namespace tandem
