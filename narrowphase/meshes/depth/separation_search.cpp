// The methods of the search for the shortest separating translation.
#include "meshes/depth/separation_search.h"

#include <algorithm>
#include <cmath>

#include "shapes/unit_vector.h"
#include "tolerances.h"

namespace tandem {

Vec3 OverlappingPair::farther(const Vec3& move) const {
  return move + tolerance::alike * size * unit(move, move.norm());
}

void SeparationSearch::take(const Vec3& translation) {
  known.length = translation.norm();
  known.normal = unit(translation, known.length);
}

void SeparationSearch::along(const Vec3& direction) {
  if (!(direction.norm() > 0.5)) return;
  const double length = pair_.free_length(direction, known);
  if (length < known.length) known.length = length, known.normal = direction;
}

void SeparationSearch::beyond(std::span<const Constraint> constraints) {
  Vec3 translation;
  if (shortest_feasible(constraints, pair_.slack, translation) && translation.norm() < known.length &&
      pair_.is_free(translation))
    take(translation);
}

void SeparationSearch::beyond_obstacles() {
  constexpr int rounds = 8;
  Vec3 at = Vec3::Zero();
  bool leads_on = pair_.add_constraints(at, constraints_);
  for (int i = 0; i < rounds && leads_on; ++i) {
    if (!constraints_.shortest(-infinity, pair_.slack, at) || !(at.norm() > 0 && at.norm() < known.length)) break;
    const Vec3 farther = pair_.farther(at);
    const bool here = pair_.collide(at);
    if (here || pair_.collide(farther)) {
      leads_on = pair_.add_constraints(here ? at : farther, constraints_);
      continue;
    }
    take(at);
    if (Vec3 to; pair_.effort.margin == 0 && constraints_.shortest(-infinity, 0, to)) {
      // Beyond two planes that it grazes, the corner without slack lies aside: the length is that along another normal.
      if ((to - at).norm() <= 2 * pair_.slack)
        known.length = to.norm();
      else if (pair_.is_free(to))
        take(to);
    }
    if (const LocalConstraint* active = constraints_.active_at(at)) known.point = active->point;
    break;
  }
  raise_certain();
}

void SeparationSearch::shorten() {
  const SearchEffort& effort = pair_.effort;
  const Separation before = known;
  std::vector<Constraint> planes;
  double ahead = tolerance::far_apart * pair_.size;
  for (int i = 0; i < effort.rounds; ++i, ahead = std::max(0.1 * ahead, tolerance::least_apart * pair_.size)) {
    const Vec3 at = (known.length + ahead) * known.normal;
    const double reach = std::isfinite(effort.plane_reach) ? effort.plane_reach * pair_.size : known.length + ahead;
    Vec3 to;
    if (!pair_.separating_planes(at, reach, planes)) break;
    for (Constraint& plane : planes) plane.bound += effort.margin * pair_.slack;
    if (!shortest_feasible(planes, effort.plane_slack * pair_.slack, to)) break;
    if (const double step = (to - at).norm(); step > reach)
      to = at + (tolerance::within_reach * reach / step) * (to - at);
    const double length = to.norm();
    if (!(length > 0 && length < known.length - pair_.slack)) break;
    if (effort.trust_planes || pair_.is_free(to))
      take(to);
    else
      break;
  }
  if (effort.trust_planes && known.length < before.length && !pair_.is_free(known.length * known.normal))
    known = before;
}

void SeparationSearch::confirm() {
  const double before = std::min(0.5 * known.length, tolerance::near_apart * pair_.size);
  pair_.add_constraints((known.length - before) * known.normal, constraints_);
  raise_certain();
}

// A constraint whose reach is shorter than the translation may be valid for half of it.
void SeparationSearch::raise_certain() {
  if (!std::isfinite(known.length)) return;
  for (double far = known.length; far > std::max(known.certain, pair_.effort.least_reach * known.length); far /= 2)
    if (Vec3 to; constraints_.shortest(far, 0, to)) known.certain = std::max(known.certain, std::min(far, to.norm()));
}

PairAnswer SeparationSearch::answer() const {
  PairAnswer answer;
  answer.collide = true;
  answer.normal = known.normal;
  // Without the margin for rounding.
  answer.signed_distance = -(is_shortest() ? known.certain : known.length);
  if (!is_shortest()) {
    answer.status = Status::inexact;
    answer.error_bound = known.length - known.certain;
  }
  return answer;
}

}  // namespace tandem
