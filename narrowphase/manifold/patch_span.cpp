// Which of a patch's points are kept.
#include "manifold/feature_overlap.h"
#include "manifold/manifold.h"
#include "tolerances.h"

namespace tandem {

void stand_for_deepest(PatchPoint* p, int count, double slack) {
  int first = 0;
  double deepest = p[0].depth;
  for (int i = 1; i < count; ++i) {
    if (p[i].depth > p[first].depth + slack) first = i;
    deepest = std::max(deepest, p[i].depth);
  }
  p[first].depth = deepest;
}

int span_patch(PatchPoint* p, int count, const Vec3& normal, double size) {
  const auto before = [](const PatchPoint& x, const PatchPoint& y) {
    return x.feature != y.feature ? x.feature < y.feature : x.depth > y.depth;
  };
  for (int i = 1; i < count; ++i)
    for (int k = i; k > 0 && before(p[k], p[k - 1]); --k) std::swap(p[k], p[k - 1]);
  if (count <= 2) return count;
  // The best of those not taken; a later one must be better by more than the slack.
  const double slack = tolerance::alike * size;
  bool taken[max_patch] = {};
  double most;
  const auto choose = [&](auto&& score) {
    int best = -1;
    most = 0;
    for (int i = 0; i < count; ++i) {
      if (taken[i]) continue;
      const double s = score(p[i]);
      if (best < 0 || s > most + slack) best = i, most = s;
    }
    taken[best] = true;
    return best;
  };
  double deepest = p[0].depth;
  for (int i = 1; i < count; ++i) deepest = std::max(deepest, p[i].depth);
  int start = -1;
  for (int i = 0; i < count; ++i)
    if (p[i].rim && p[i].depth >= deepest - rim_lacks * slack) start = i;
  if (start < 0)
    start = choose([&](const PatchPoint& x) { return x.feature == witness_point ? size : x.depth; });
  else
    taken[start] = true;
  const PatchPoint& first = p[start];
  p[start].depth = deepest;  // one that counts as equal stands for the deepest
  const auto from_first = [&first](const PatchPoint& x) { return (x.at - first.at).norm(); };
  const int second = choose(from_first);
  const double length = most;
  const Vec3 along = p[second].at - first.at, side = normal.cross(along / std::max(length, tolerance::never_zero));
  const int third = choose([&](const PatchPoint& x) { return std::abs(side.dot(x.at - first.at)); });
  if (most <= thin * length) {
    // A strip this thin is an edge: its deepest end, and the deepest at the other.
    taken[second] = taken[third] = false;
    choose([&](const PatchPoint& x) { return from_first(x) >= 0.9 * length ? size + x.depth : 0; });
  } else if (count > 4) {
    // The fourth: outside the triangle of the three by most.
    const double turn = side.dot(p[third].at - first.at) >= 0 ? 1.0 : -1.0;
    const Vec3 corner[4] = {first.at, p[second].at, p[third].at, first.at};
    Vec3 outward[3];
    for (int k = 0; k < 3; ++k) outward[k] = -turn * normal.cross(corner[k + 1] - corner[k]).normalized();
    const int fourth = choose([&](const PatchPoint& x) {
      double out = 0;
      for (int k = 0; k < 3; ++k) out = std::max(out, outward[k].dot(x.at - corner[k]));
      return out;
    });
    if (!(most > slack)) taken[fourth] = false;
  } else {
    return count;
  }
  int kept = 0;
  for (int i = 0; i < count; ++i)
    if (taken[i]) p[kept++] = p[i];
  return kept;
}

}  // namespace tandem
