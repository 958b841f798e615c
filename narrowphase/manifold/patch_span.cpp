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

namespace {

/// Points of a patch, of which some are taken one by one.
class PatchChoice {
 public:
  PatchChoice(PatchPoint* p, int count, double slack) : p_(p), count_(count), slack_(slack) {}

  /// The best of those not taken; a later one must be better by more than the slack.
  template <class Score>
  int take(const Score& score) {
    int best = -1;
    most_ = 0;
    for (int i = 0; i < count_; ++i) {
      if (taken_[i]) continue;
      const double s = score(p_[i]);
      if (best < 0 || s > most_ + slack_) best = i, most_ = s;
    }
    taken_[best] = true;
    return best;
  }
  /// The score of the last.
  double most() const { return most_; }
  int take(int i) {
    taken_[i] = true;
    return i;
  }
  void leave(int i) { taken_[i] = false; }

  /// Moves those taken to the front, in their order; how many.
  int gather() {
    int kept = 0;
    for (int i = 0; i < count_; ++i)
      if (taken_[i]) p_[kept++] = p_[i];
    return kept;
  }

 private:
  PatchPoint* p_;
  int count_;
  double slack_, most_ = 0;
  bool taken_[max_patch] = {};
};

/// In an order that does not depend on how they were found.
void sort_points(PatchPoint* p, int count) {
  const auto before = [](const PatchPoint& x, const PatchPoint& y) {
    return x.feature != y.feature ? x.feature < y.feature : x.depth > y.depth;
  };
  for (int i = 1; i < count; ++i)
    for (int k = i; k > 0 && before(p[k], p[k - 1]); --k) std::swap(p[k], p[k - 1]);
}

/// The deepest point, or one that counts as equal and then stands for it: the disc's own, else the witness.
int take_first(PatchPoint* p, int count, double size, double slack, PatchChoice& choice) {
  double deepest = p[0].depth;
  for (int i = 1; i < count; ++i) deepest = std::max(deepest, p[i].depth);
  int start = -1;
  for (int i = 0; i < count; ++i)
    if (p[i].lowest && p[i].depth >= deepest - lowest_point_lacks * slack) start = i;
  if (start < 0)
    start = choice.take([&](const PatchPoint& x) { return x.feature == witness_point ? size : x.depth; });
  else
    choice.take(start);
  p[start].depth = deepest;
  return start;
}

/// The fourth: outside the triangle of the three by most, if by more than the slack.
void take_outside(const Vec3& first, const Vec3& second, const Vec3& third, double turn, const Vec3& normal,
                  double slack, PatchChoice& choice) {
  const Vec3 corner[4] = {first, second, third, first};
  Vec3 outward[3];
  for (int k = 0; k < 3; ++k) outward[k] = -turn * normal.cross(corner[k + 1] - corner[k]).normalized();
  const int fourth = choice.take([&](const PatchPoint& x) {
    double out = 0;
    for (int k = 0; k < 3; ++k) out = std::max(out, outward[k].dot(x.at - corner[k]));
    return out;
  });
  if (!(choice.most() > slack)) choice.leave(fourth);
}

}  // namespace

int span_patch(PatchPoint* p, int count, const Vec3& normal, double size) {
  sort_points(p, count);
  if (count <= 2) return count;
  const double slack = tolerance::alike * size;
  PatchChoice choice(p, count, slack);
  const PatchPoint& first = p[take_first(p, count, size, slack, choice)];
  const auto from_first = [&first](const PatchPoint& x) { return (x.at - first.at).norm(); };
  const int second = choice.take(from_first);
  const double length = choice.most();
  const Vec3 along = p[second].at - first.at, side = normal.cross(along / std::max(length, tolerance::never_zero));
  const int third = choice.take([&](const PatchPoint& x) { return std::abs(side.dot(x.at - first.at)); });
  if (choice.most() <= thin * length) {
    // A strip this thin is an edge: its deepest end, and the deepest at the other.
    choice.leave(second);
    choice.leave(third);
    choice.take([&](const PatchPoint& x) { return from_first(x) >= 0.9 * length ? size + x.depth : 0; });
  } else if (count > 4) {
    const double turn = side.dot(p[third].at - first.at) >= 0 ? 1.0 : -1.0;
    take_outside(first.at, p[second].at, p[third].at, turn, normal, slack, choice);
  } else {
    return count;
  }
  return choice.gather();
}

}  // namespace tandem
