// The shortest translation that satisfies linear constraints.
#include "meshes/traversal/least_translation.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "tolerances.h"

namespace tandem {

// Adds one constraint after the other: if the previous solution violates it, the new one lies on its plane (Seidel,
// Small-dimensional linear programming and convex hulls made easy, 1991, without shuffling).
bool shortest_feasible(std::span<const Constraint> constraints, double slack, Vec3& shortest) {
  shortest.setZero();
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const Constraint& plane = constraints[i];
    if (plane.normal.dot(shortest) >= plane.bound - slack) continue;
    // Within its plane, starting from its point nearest the origin.
    const Vec3 foot = plane.bound * plane.normal;
    const auto within = [&](const Constraint& w) {
      return Constraint{w.normal - w.normal.dot(plane.normal) * plane.normal, w.bound - w.normal.dot(foot)};
    };
    Vec3 y = Vec3::Zero();
    for (std::size_t j = 0; j < i; ++j) {
      const Constraint line = within(constraints[j]);
      if (line.normal.dot(y) >= line.bound - slack) continue;
      const double length2 = line.normal.squaredNorm();
      if (!(length2 > tolerance::parallel_planes2)) return false;
      // Along the line where the two planes intersect.
      const Vec3 on_line = (line.bound / length2) * line.normal;
      const Vec3 along = plane.normal.cross(line.normal) / std::sqrt(length2);
      double low = -infinity, high = infinity;
      for (std::size_t k = 0; k < j; ++k) {
        const Constraint other = within(constraints[k]);
        const double slope = other.normal.dot(along), left = other.bound - other.normal.dot(on_line);
        if (slope > tolerance::parallel_lines) low = std::max(low, left / slope);
        if (slope < -tolerance::parallel_lines) high = std::min(high, left / slope);
        if (std::abs(slope) <= tolerance::parallel_lines && left > slack) return false;
      }
      if (low > high + slack) return false;
      y = on_line + std::clamp(0.0, low, std::max(low, high)) * along;
    }
    shortest = foot + y;
  }
  return true;
}

bool LocalConstraints::implies(const LocalConstraint& stronger, const LocalConstraint& weaker) const {
  return stronger.normal.dot(weaker.normal) > tolerance::one_direction && stronger.bound >= weaker.bound - slack_ &&
         stronger.reach >= weaker.reach;
}

bool LocalConstraints::imply(const LocalConstraint& constraint) const {
  return std::any_of(constraints_.begin(), constraints_.end(),
                     [&](const LocalConstraint& known) { return implies(known, constraint); });
}

bool LocalConstraints::add(const LocalConstraint& constraint) {
  constexpr std::size_t most = 48;
  if (imply(constraint)) return false;
  std::erase_if(constraints_, [&](const LocalConstraint& known) { return implies(constraint, known); });
  if (constraints_.size() == most) return false;
  constraints_.push_back(constraint);
  return true;
}

bool LocalConstraints::add_contacts(std::span<const Contact> contacts, const Vec3& moved_by, double more) {
  bool is_new = false;
  for (const Contact& c : contacts)
    is_new = add({{c.normal, c.normal.dot(moved_by) + c.depth + more}, infinity, Vec3::Zero()}) || is_new;
  return is_new;
}

bool LocalConstraints::shortest(double reach, double more, Vec3& translation) const {
  std::vector<Constraint> those;
  for (const LocalConstraint& c : constraints_)
    if (c.reach >= reach) those.push_back({c.normal, c.bound + more});
  std::stable_sort(those.begin(), those.end(),
                   [](const Constraint& x, const Constraint& y) { return x.bound > y.bound; });
  return shortest_feasible(those, slack_ / 8, translation);
}

const LocalConstraint* LocalConstraints::active_at(const Vec3& translation) const {
  const LocalConstraint* active = nullptr;
  double most = -infinity;
  for (const LocalConstraint& c : constraints_)
    if (const double share = c.normal.dot(translation); share <= c.bound + 2 * slack_ && share > most)
      most = share, active = &c;
  return active;
}

}  // namespace tandem
