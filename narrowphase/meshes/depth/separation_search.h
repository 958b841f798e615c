// The search for the shortest translation that separates two bodies of which one at least is a mesh: methods that each
// shorten the translation that is known or raise the bound below it. Which of them to ask for two bodies, and in which
// order, is their solver's policy.
#pragma once
#include <span>
#include <vector>

#include "meshes/depth/least_translation.h"
#include "tandem/narrowphase/answer.h"
#include "tolerances.h"

namespace tandem {

/// What is known of the shortest translation of B that separates.
struct Separation {
  double certain = 0;        ///< no shorter one does
  double length = infinity;  ///< one this long does, along the normal
  Vec3 normal = Vec3::UnitZ();
  Vec3 point = Vec3::Zero();  ///< midway between points that are last to separate
};

/// Numbers of the search that differ between pairs, whose queries differ in cost.
struct SearchEffort {
  double enough;        ///< how much longer than what is certain a translation may be to be the shortest, metres
  double least_reach;   ///< of constraints that bound the length from below, relative to it
  int rounds;           ///< of planes about the end of the translation
  double plane_reach;   ///< how far about it, metres; infinity: as far as it is long
  double margin;       ///< how far beyond what it has left a translation ends, metres; 0: on it
  double plane_slack;   ///< to what the planes are known, metres
  bool trust_planes;    ///< what they leave is tried at the last only
};

/// Two bodies that overlap, as the search asks about them. B moves, along axes of the pair's own.
class OverlappingPair {
 public:
  OverlappingPair(double size, const SearchEffort& effort) : size(size), effort(effort) {}
  virtual ~OverlappingPair() = default;

  const double size;  ///< of both, metres
  const double slack = tolerance::place_rounding * size;
  const SearchEffort effort;

  /// A little farther than a translation, which may end where what B leaves and what comes next touch both, and
  /// rounding say that neither does; or in a gap just as wide as B.
  Vec3 farther(const Vec3& move) const;

  /// Do the two collide with B moved?
  virtual bool collide(const Vec3& move) const = 0;

  /// Does a translation separate, and does a little farther along it, too?
  virtual bool is_free(const Vec3& move) const = 0;

  /// The length of a translation along a direction (unit) that separates; none, infinity, if that is not less than
  /// known.length.
  virtual double free_length(const Vec3& direction, const Separation& known) const = 0;

  /// Adds constraints by what reaches through what with B moved by `at`, where they collide. False: none is new, or no
  /// translation satisfies them all.
  virtual bool add_constraints(const Vec3& at, LocalConstraints& constraints) const = 0;

  /// Planes that separate all of B, moved by `at`, from what of A is less than `reach` away, as constraints: whatever
  /// translation satisfies them and ends no farther than that from `at` separates. False: two touch, or it would be too
  /// much work.
  virtual bool separating_planes(const Vec3& at, double reach, std::vector<Constraint>& planes) = 0;
};

class SeparationSearch {
 public:
  SeparationSearch(OverlappingPair& pair, const Separation& known)
      : known(known), pair_(pair), constraints_(pair.slack) {}

  Separation known;

  /// Is the translation that is known as short as any?
  bool is_shortest() const { return known.length <= known.certain + pair_.effort.enough; }

  /// Along a direction (unit; zero: nothing).
  void along(const Vec3& direction);

  /// The shortest translation that constraints leave, if it is free.
  void beyond(std::span<const Constraint> constraints);

  /// The shortest translation beyond all that reaches through something here, and there, and so on.
  void beyond_obstacles();

  /// Makes the translation that is known shorter by the planes about its end, down to one that nothing near it is
  /// shorter than.
  void shorten();

  /// Raises what is certain by what holds B shortly before the end of the translation that is known.
  void confirm();

  /// The length, its status and the normal, in the pair's axes; without points.
  PairAnswer answer() const;

 private:
  void take(const Vec3& translation);
  void raise_certain();

  OverlappingPair& pair_;
  LocalConstraints constraints_;
};

}  // namespace tandem
