// Sums over the pairs with kept answers, updated as pairs are added, change and are removed.
#pragma once
#include "pipeline/kept_pair.h"

namespace tandem {

/// The largest of the pairs' values and the number of pairs that have it, so that one can be removed without a search.
struct KeptPeak {
  double value = 0;
  std::int64_t pairs = 0;
  void add(double its, std::int64_t count) {
    if (its < value) return;
    pairs = its == value ? pairs + count : count;
    value = its;
  }
};

/// The change of the sums over all candidates by one batch.
struct KeptSums {
  std::int64_t computed = 0, recorded = 0, colliding = 0, touching = 0, gaps = 0, inexact = 0;
  KeptPeak depth, error_bound;                          // of pairs that are added
  std::int64_t left_top_depth = 0, left_top_bound = 0;  // removed pairs that had the largest value of all

  void leave(const KeptEntry& entry, const KeptLargest& its, const KeptSums& of_all);
  void enter(const KeptEntry& entry, const KeptLargest& its);
  void add(const KeptSums& other);
};

inline void KeptSums::leave(const KeptEntry& entry, const KeptLargest& its, const KeptSums& of_all) {
  colliding -= entry.collide ? 1 : 0;
  touching -= entry.touching;
  gaps -= entry.gaps;
  inexact -= entry.inexact ? 1 : 0;
  left_top_depth += its.depth == of_all.depth.value ? 1 : 0;
  left_top_bound += its.error_bound == of_all.error_bound.value ? 1 : 0;
}

inline void KeptSums::enter(const KeptEntry& entry, const KeptLargest& its) {
  colliding += entry.collide ? 1 : 0;
  touching += entry.touching;
  gaps += entry.gaps;
  inexact += entry.inexact ? 1 : 0;
  depth.add(its.depth, 1);
  error_bound.add(its.error_bound, 1);
}

inline void KeptSums::add(const KeptSums& other) {
  computed += other.computed;
  recorded += other.recorded;
  colliding += other.colliding;
  touching += other.touching;
  gaps += other.gaps;
  inexact += other.inexact;
  depth.add(other.depth.value, other.depth.pairs);
  error_bound.add(other.error_bound.value, other.error_bound.pairs);
  left_top_depth += other.left_top_depth;
  left_top_bound += other.left_top_bound;
}

}  // namespace tandem
