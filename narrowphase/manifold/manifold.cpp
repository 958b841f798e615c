// Builds contact manifolds, and keeps at most four points that span them.
#include "manifold/manifold.h"

#include "manifold/feature_overlap.h"
#include "manifold/flat_feature.h"
#include "tolerances.h"

namespace tandem {

void append_points(const PatchPoint* points, int count, const Pose& pose, const Vec3& normal,
                   std::vector<Contact>& contacts) {
  for (int i = 0; i < count; ++i) contacts.push_back({pose * points[i].at, normal, points[i].depth, points[i].feature});
}

bool set_deepest(PatchPoint* points, int count, double depth, double slack) {
  double deepest = -infinity;
  bool lowest = false;
  for (int i = 0; i < count; ++i) {
    deepest = std::max(deepest, points[i].depth);
    lowest |= points[i].lowest;
  }
  if (!(deepest + (lowest ? lowest_point_lacks : 0.02) * slack >= depth)) return false;
  for (int i = 0; i < count; ++i)
    if (points[i].depth == deepest) points[i].depth = depth;
  return true;
}

namespace {

/// The features of two shapes that face each other.
struct FacingFeatures {
  FlatFeature a, b;  ///< both in A's frame
};

/// Those along n. Of faces with too many corners those where the other feature lies are kept.
FacingFeatures facing_features(const ConvexView& a, const ConvexView& b, const RelativePose& relative, const Vec3& n) {
  const Mat3 back = relative.rotation.transpose();
  const Vec3 towards_a = -(back * n);
  FacingFeatures f{best_face(a, n), best_face(b, towards_a)};
  const bool more_of_a = has_more_corners(a, f.a), more_of_b = has_more_corners(b, f.b);
  if (more_of_a || more_of_b) {
    FlatFeature a_in_b = f.a, b_in_a = f.b;
    move(a_in_b, {back, -(back * relative.translation)});
    move(b_in_a, relative);
    if (more_of_a) f.a = best_face(a, n, &b_in_a);
    if (more_of_b) f.b = best_face(b, towards_a, &a_in_b);
  }
  move(f.b, relative);
  return f;
}

}  // namespace

void append_manifold(const ConvexView& a, const ConvexView& b, const RelativePose& relative, const LocalAnswer& answer,
                     double margin, const Pose& pose_a, std::vector<Contact>& contacts, bool whole) {
  if (answer.signed_distance > margin) return;
  const Vec3& n = answer.normal;
  PatchPoint points[max_patch];
  int count = 0;
  const double slack = tolerance::alike * (a.size + b.size);
  const bool point_like = a.kind == ShapeKind::sphere || b.kind == ShapeKind::sphere ||
                          a.kind == ShapeKind::ellipsoid || b.kind == ShapeKind::ellipsoid;
  if (!point_like) {
    FacingFeatures facing = facing_features(a, b, relative, n);
    FlatFeature &fa = facing.a, &fb = facing.b;
    const double flat_a = fa.is_face() ? fa.normal.dot(n) : 0, flat_b = fb.is_face() ? -fb.normal.dot(n) : 0;
    // Two equally aligned faces: A's is the reference, except that a leaning disc is always the incident one, because
    // its deepest point must remain.
    const bool as_flat = std::abs(flat_a - flat_b) <= tolerance::alike_cosines;
    const bool only_a_leans = as_flat && fa.lowest >= 0 && fb.lowest < 0;
    if (flat_a >= carries_patch && (as_flat || flat_a > flat_b) && !(only_a_leans && flat_b >= carries_patch)) {
      count = clip_faces(fa, fb, n, false, margin, -answer.signed_distance, slack, points);
    } else if (flat_b >= carries_patch) {
      count = clip_faces(fb, fa, -n, true, margin, -answer.signed_distance, slack, points);
    } else {
      fa = flush_edge(a, n);
      if (fa.count == 2) fb = flush_edge(b, -(relative.rotation.transpose() * n));
      if (fa.count == 2 && fb.count == 2) {
        move(fb, relative);
        count = overlap_edges(fa, fb, answer, margin, a.size + b.size, points);
      }
    }
    if (count > 0 && set_deepest(points, count, -answer.signed_distance, slack)) {
      if (!whole) count = span_patch(points, count, n, a.size + b.size);
      append_points(points, count, pose_a, pose_a.rotation * n, contacts);
      return;
    }
  }
  points[count++] = {0.5 * (answer.point_a + answer.point_b), -answer.signed_distance, witness_point};
  if (!whole) count = span_patch(points, count, n, a.size + b.size);
  append_points(points, count, pose_a, pose_a.rotation * n, contacts);
}

bool append_parallel_capsules(const SegmentDistance& axes, double radius_a, double length_a, const Pose& pose_a,
                              double radius_b, double length_b, const Pose& pose_b, double margin,
                              std::vector<Contact>& contacts) {
  const Vec3 along = pose_a.rotation.col(2), other = pose_b.rotation.col(2);
  if (along.cross(other).squaredNorm() > tolerance::flush2 || std::abs(axes.normal.dot(along)) > tolerance::flush)
    return false;
  // Positions along A's axis from its centre.
  const double centre = along.dot(pose_b.translation - pose_a.translation), sense = along.dot(other) >= 0 ? 0.5 : -0.5;
  const double ha = 0.5 * length_a, hb = 0.5 * length_b;
  const double lo = std::max(-ha, centre - hb), hi = std::min(ha, centre + hb);
  if (!(hi - lo > tolerance::flush * (length_a + length_b))) return false;
  const double depth = radius_a + radius_b - axes.distance;
  // The gap of the axes at A's centre, and its change along them: each end has its own midpoint.
  const std::size_t first = contacts.size();
  for (const double end : {lo, hi}) {
    const Vec3 on_a = end * along;
    const Vec3 on_b = pose_b.translation - pose_a.translation + (end - centre) * (2 * sense) * other;
    const double here = radius_a + radius_b - axes.normal.dot(on_b - on_a);
    const Vec3 at = 0.5 * ((on_a + radius_a * axes.normal) + (on_b - radius_b * axes.normal));
    if (here < -margin - tolerance::alike * (length_a + length_b)) continue;
    contacts.push_back(
        {pose_a.translation + at, axes.normal, std::max(std::min(here, depth), -margin), end == lo ? 0u : 1u});
  }
  return contacts.size() > first;
}

void append_halfspace_manifold(const ConvexView& shape, const Pose& pose, const Vec3& normal, double offset,
                               double margin, std::vector<Contact>& contacts) {
  const FlatFeature f = best_face(shape, -normal);
  PatchPoint points[max_corners + 1];
  int count = 0;
  double deepest = -infinity;
  for (int i = 0; i < f.count; ++i) {
    const double depth = offset - normal.dot(f.corner[i]);
    if (depth < -margin - tolerance::alike * shape.size) continue;
    const double kept = std::max(depth, -margin);
    deepest = std::max(deepest, kept);
    points[count++] = {f.corner[i] + 0.5 * depth * normal, kept,
                       (f.id << 8 & 0x7fffff00u) | static_cast<std::uint32_t>(i), i == f.lowest};
  }
  const Vec3 lowest = core_support(shape, -normal) - core_radius(shape) * normal;
  const double depth = offset - normal.dot(lowest);
  if (depth > deepest + tolerance::deeper * shape.size) {
    points[count++] = {lowest + 0.5 * depth * normal, depth, 0x80000000u};
  } else {
    // The corners of a disc's circle represent the arcs between them.
    for (int i = 0; i < count; ++i)
      if (points[i].depth == deepest) points[i].depth = depth;
  }
  count = span_patch(points, count, normal, shape.size);
  append_points(points, count, pose, pose.rotation * normal, contacts);
}

void share_greatest_depth(PatchPoint* p, int count, double slack) {
  int first = 0;
  double deepest = p[0].depth;
  for (int i = 1; i < count; ++i) {
    if (p[i].depth > p[first].depth + slack) first = i;
    deepest = std::max(deepest, p[i].depth);
  }
  p[first].depth = deepest;
}

namespace {

/// The points of a patch, of which some are taken one by one.
class PatchChoice {
 public:
  PatchChoice(PatchPoint* p, int count, double slack) : p_(p), count_(count), slack_(slack) {}

  /// The point with the best score of those not taken; a later one must be better by more than the slack.
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
  /// The score of the last one taken.
  double most() const { return most_; }
  int take(int i) {
    taken_[i] = true;
    return i;
  }
  void leave(int i) { taken_[i] = false; }

  /// Moves the taken points to the front, in their order; returns how many.
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

/// Sorts points so that the result does not depend on the order in which they were found.
void sort_points(PatchPoint* p, int count) {
  const auto before = [](const PatchPoint& x, const PatchPoint& y) {
    return x.feature != y.feature ? x.feature < y.feature : x.depth > y.depth;
  };
  for (int i = 1; i < count; ++i)
    for (int k = i; k > 0 && before(p[k], p[k - 1]); --k) std::swap(p[k], p[k - 1]);
}

/// The deepest point, or one that is equally deep and then represents it: that of a leaning disc, else the witness.
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

/// The fourth point: farthest outside the triangle of the three, if by more than the slack.
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
    // A strip this thin is an edge: keep its deepest end, and the deepest point at the other.
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
