// Linear constraints on the translations that separate two bodies, and the shortest translation that satisfies them.
#pragma once
#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "shapes/unit_vector.h"
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

  const std::vector<LocalConstraint>& all() const { return constraints_; }

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

/// How precise the translations of translation_off_all are, metres.
struct OffPrecision {
  double slack;   ///< of constraints
  double more;    ///< what each constraint is enlarged by at first, and by four times that where it is not enough
  double most;    ///< the most of that
  double little;  ///< how much farther B must be free, too
};

/// A translation of B that separates, by constraints found in rounds: add(at, round, constraints) adds those of what
/// touches with B translated by `at`, at first by `first`, false: nothing new; collide(at): whether they collide there.
/// It is free a little farther, too: along itself or, where it ends at the other side of a notch, off all that it has
/// left. None if constraints contradict each other, as in a slot exactly as wide as B, or the last round finds new
/// ones.
template <class Add, class Collide>
std::optional<Vec3> translation_off_all(const Vec3& first, const OffPrecision& precision, const Add& add,
                                        const Collide& collide) {
  constexpr int rounds = 8;
  LocalConstraints off(precision.slack);
  std::vector<Vec3> from{first};
  Vec3 at = Vec3::Zero(), beyond = at;
  double more = precision.more;
  for (int i = 0; i < rounds; ++i) {
    bool is_new = false;
    for (const Vec3& place : from) is_new = add(place, i, off) || is_new;
    if (!is_new && more >= precision.most) break;
    if (!is_new) more = std::min(4 * more, precision.most);
    if (!off.shortest(infinity, more, at)) break;
    from = {at};
    if (collide(at)) continue;
    from = {at + precision.little * unit(at)};
    const bool is_free = !collide(from.front());
    if (!is_free && !off.shortest(infinity, more + precision.little, beyond)) break;
    if (is_free || !collide(beyond)) return at;
    from.push_back(beyond);
  }
  return std::nullopt;
}

}  // namespace tandem
