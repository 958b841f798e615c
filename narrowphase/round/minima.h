// The local minima found of h, the support of two bodies' difference.
#pragma once
#include "round/support_descent.h"
#include "shapes/work_meter.h"

namespace tandem {

/// Work on a hull's edges, in units of the meter, before a limit is first checked: for a large hull none.
inline int unchecked_edges(const Hull& hull) {
  constexpr int few_edges = 512;
  return hull.edges.size() > few_edges ? 0 : few_edges;
}

/// The known minima of h during the search for the least.
struct Minima {
  static constexpr int most_known = 24;

  const RoundPair& pair;
  double rounding;  ///< metres: smaller differences count as equal
  Support best;
  Vec3 known[most_known];  ///< their directions
  int count = 0;
  double gap = 0;  ///< by how much the least may be below best.h, because of what was left out

  Minima(const RoundPair& pair_, const Support& start)
      : pair(pair_), rounding(16 * epsilon * pair_.scale), best(start) {}

  void note(const Vec3& n) {
    if (count < most_known) known[count++] = n;
  }
  /// Descends from n; returns the minimum's direction.
  Vec3 try_from(const Vec3& n) {
    const Support s = minimize(pair, n, -infinity);
    note(s.n);
    if (s.h < best.h) best = s;
    return s.n;
  }
};

}  // namespace tandem
