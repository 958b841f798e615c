// The local minima found of what two bodies reach together along directions.
#pragma once
#include "round/support_descent.h"
#include "shapes/work_meter.h"

namespace tandem {

/// Units of work on a hull's edges before a limit is first looked at: most hulls have fewer.
inline constexpr int few_edges = 512;

/// The minima of h that are known while the least is searched for.
struct Minima {
  static constexpr int most_known = 24;

  const RoundPair& pair;
  double rounding;  ///< metres: what is less by no more is not less
  Support best;
  Vec3 known[most_known];  ///< their directions
  int count = 0;
  double gap = 0;  ///< how much less than best.h the least may be, of what was left out

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
