// Linear constraints on the translations that separate two bodies, and the shortest translation that satisfies them.
#pragma once
#include <span>
#include <vector>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// A constraint on translations t: normal (unit) . t >= bound.
struct Constraint {
  Vec3 normal;
  double bound;
};

/// The shortest translation that satisfies all constraints, each to `slack`; false if there is none.
bool shortest_feasible(std::span<const Constraint> constraints, double slack, Vec3& shortest);

/// A constraint satisfied by all translations that separate the bodies and are not longer than `reach`.
struct LocalConstraint : Constraint {
  double reach;
  Vec3 point;  ///< midway between the points of the two bodies that touch where the constraint ends
};

/// Local constraints; of those along one direction only the strongest is kept.
class LocalConstraints {
 public:
  /// `slack`: precision of translations, metres.
  explicit LocalConstraints(double slack) : slack_(slack) {}

  /// True if the known constraints imply this one.
  bool imply(const LocalConstraint& constraint) const;

  /// False if it is implied, or there are too many.
  bool add(const LocalConstraint& constraint);

  /// The shortest translation that satisfies the constraints of at least that reach, each bound enlarged by `more`;
  /// false if there is none.
  bool shortest(double reach, double more, Vec3& translation) const;

  /// The constraint that a translation satisfies with the least slack, which is at most one or two `slack`; else
  /// nullptr.
  const LocalConstraint* active_at(const Vec3& translation) const;

 private:
  bool implies(const LocalConstraint& stronger, const LocalConstraint& weaker) const;

  double slack_;
  std::vector<LocalConstraint> constraints_;
};

}  // namespace tandem
