// What takes two bodies off their parts that touch, each by the least that this takes.
#pragma once
#include <algorithm>
#include <vector>

#include "meshes/traversal/least_translation.h"
#include "tandem/narrowphase/answer.h"
#include "tolerances.h"

namespace tandem {

/// Adds constraints for B translated by `at`, pair by pair of parts: of triangles, or of a triangle and a convex shape.
/// Gaps along a direction (unit, from A to B) are those of a pair, negative where it overlaps, metres.
class OffParts {
 public:
  OffParts(const Vec3& at, double slack, LocalConstraints& off) : at_(at), slack_(slack), off_(off) {}

  /// The outside of a solid where B touches it (unit, from A to B); zero: not known. All come before the pairs: a thin
  /// part in the plane of a solid's triangle, or at its edge, may leave it into the solid.
  void add_outside(const Vec3& n) {
    if (n.norm() > 0.5) outsides_.push_back(n);
  }

  /// True if the known constraints already take B off a pair, to its outside `n`.
  template <class GapAlong>
  bool leave(const Vec3& n, const GapAlong& gap_along) const {
    const auto leaves = [&](const Constraint& known) {
      return !are_opposite(known.normal, n) && gap_along(known.normal) >= known.normal.dot(at_) - known.bound - slack_;
    };
    return std::any_of(off_.all().begin(), off_.all().end(), leaves);
  }

  /// Takes B off a pair along `r`, its least depth; along its outside `n`, if that leads into a solid and there is
  /// nothing else to leave.
  template <class GapAlong>
  void add(const PairAnswer& r, const Vec3& n, const GapAlong& gap_along) {
    const auto blocks = [&](const Vec3& outside) { return are_opposite(r.normal, outside); };
    const auto opposes = [&](const Constraint& known) { return are_opposite(r.normal, known.normal); };
    const bool to_outside = r.normal.dot(n) > tolerance::one_direction;
    if (std::any_of(off_.all().begin(), off_.all().end(), opposes) ||
        (!to_outside && std::any_of(outsides_.begin(), outsides_.end(), blocks))) {
      if (n.norm() > 0.5) outward_.push_back(off_along(n, gap_along(n)));
    } else {
      add(r.normal, r.signed_distance);
    }
  }

  void add(const Vec3& normal, double gap) { is_new_ = off_.add(off_along(normal, gap)) || is_new_; }

  /// True if there are new constraints.
  bool finish() {
    if (is_new_) return true;
    for (const LocalConstraint& c : outward_) is_new_ = off_.add(c) || is_new_;
    return is_new_;
  }

 private:
  // Within 8 degrees: rounding turns the direction between parts that touch.
  static constexpr double opposite = -0.99;  // cosine
  static bool are_opposite(const Vec3& n, const Vec3& m) { return n.dot(m) < opposite; }
  LocalConstraint off_along(const Vec3& n, double gap) const { return {{n, n.dot(at_) - gap}, infinity, Vec3::Zero()}; }

  const Vec3 at_;
  const double slack_;
  LocalConstraints& off_;
  std::vector<Vec3> outsides_;
  std::vector<LocalConstraint> outward_;
  bool is_new_ = false;
};

}  // namespace tandem
