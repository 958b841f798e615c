// Linear constraints on the translations that separate two bodies, and the shortest translation that satisfies them.
#pragma once
#include <span>
#include <vector>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// Translations t with normal (unit) . t >= bound.
struct Constraint {
  Vec3 normal;
  double bound;
};

/// The shortest translation that satisfies all constraints, each to `slack`; false where there is none.
bool shortest_feasible(std::span<const Constraint> constraints, double slack, Vec3& shortest);

/// A constraint that all translations satisfy that separate the bodies and are no longer than `reach`.
struct LocalConstraint : Constraint {
  double reach;
  Vec3 point;  ///< midway between the points of the two bodies that meet where the constraint ends
};

/// Local constraints, of those along one direction the strongest.
class LocalConstraints {
 public:
  /// `slack`: what translations are known to, metres.
  explicit LocalConstraints(double slack) : slack_(slack) {}

  /// Do those that are known say as much?
  bool imply(const LocalConstraint& constraint) const;

  /// False: they do, or they are too many.
  bool add(const LocalConstraint& constraint);

  /// The shortest translation that satisfies those that reach at least that far, each with its bound `more` farther
  /// out; false where there is none.
  bool shortest(double reach, double more, Vec3& translation) const;

  /// The constraint that a translation satisfies with the least to spare, which is `slack` at most or two; else
  /// nullptr.
  const LocalConstraint* active_at(const Vec3& translation) const;

 private:
  bool implies(const LocalConstraint& stronger, const LocalConstraint& weaker) const;

  double slack_;
  std::vector<LocalConstraint> constraints_;
};

}  // namespace tandem
