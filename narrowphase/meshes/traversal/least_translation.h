// Linear constraints on the translations that separate two bodies, and the shortest translation that satisfies them.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "tandem/narrowphase/answer.h"
#include "tandem/narrowphase/pose.h"
#include "tolerances.h"

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

  /// Adds what takes B, which was moved, off contacts, each of them deeper by `more`. False: nothing new.
  bool add_contacts(std::span<const Contact> contacts, const Vec3& moved_by, double more);

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

/// A translation of B that separates, by constraints found in rounds: add(at, round, constraints) adds those of what
/// touches with B translated by `at`, false: nothing new; is_free(at): that separates. `slack`: precision of
/// translations, `more`: what each constraint is enlarged by, metres. None if constraints contradict each other, or
/// there are new ones after the last round.
template <class Add, class IsFree>
std::optional<Vec3> translation_off_all(double slack, double more, const Add& add, const IsFree& is_free) {
  constexpr int rounds = 8;
  LocalConstraints off(slack);
  Vec3 at = Vec3::Zero();
  for (int i = 0; i < rounds; ++i) {
    if (!add(at, i, off) || !off.shortest(infinity, more, at)) break;
    if (is_free(at)) return at;
  }
  return std::nullopt;
}

}  // namespace tandem
