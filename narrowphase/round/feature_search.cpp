// Finds the nearest features of two bodies, and the minimum of h by them.
#include "round/feature_search.h"

#include "round/feature_body.h"
#include "round/hull_projection.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int rounds = 4;
constexpr int turns = 4;           ///< pairs of features tried a round
constexpr double clearance = 0.1;  ///< fraction of the smaller size

bool is_hull(const ConvexView& v) { return v.kind == ShapeKind::convex; }

/// The search for the nearest features: finds nearest points of both bodies held apart, and from the features on which
/// these lie the features' nearest points and their normal.
class FeatureSearch {
 public:
  FeatureSearch(const MinkowskiDifference& d, double below)
      : d_(d),
        below_(below),
        rounding_(16 * epsilon * rounding_scale(d)),
        a_{d.a, nullptr, Vec3::Zero()},
        b_{d.b, &d.pose.rotation, d.pose.translation} {}

  /// `common`: as for search_features.
  Support run(bool* common);

 private:
  void begin();
  bool separated_by_projection(bool& common);
  bool bring_near(int round, bool near, const Vec3& shift);
  bool meet(const Vec3& shift);
  bool accept(const NearestPoints& points);

  double reach(const Vec3& n) const { return a_.reach(n) + b_.reach(-n) - n.dot(d_.pose.translation); }
  void to_a(NearestPoints& points) { points.a = points.b, nearest_a_ = project(a_, points.a, rounding_, &nearest_a_); }
  void to_b(NearestPoints& points) { points.b = points.a, nearest_b_ = project(b_, points.b, rounding_, &nearest_b_); }
  bool lost() const { return nearest_a_.surface == Surface::none || nearest_b_.surface == Surface::none; }

  const MinkowskiDifference& d_;
  const double below_, rounding_;
  const FeatureBody a_;
  FeatureBody b_;
  NearestOnBody nearest_a_, nearest_b_;
  NearestPoints w_;
  bool apart_ = false;
  Support found_;
};

Support FeatureSearch::run(bool* common) {
  begin();
  if (common != nullptr && (*common = nearest_a_.inside || nearest_b_.inside)) return found_;
  const double clear = clearance * std::min(d_.a.size, d_.b.size);
  for (int round = 0; round < rounds; ++round) {
    const double h = reach(w_.n);
    if (round == 0 || h < found_.h) found_.n = w_.n, found_.h = h;
    if (h < below_) return found_;
    if (round == 0 && common != nullptr && apart_ && separated_by_projection(*common)) return found_;
    const Vec3 shift = std::max(0.0, h + clear) * w_.n;
    if (!bring_near(round, h > -clear, shift) || meet(shift)) return found_;
  }
  return found_;
}

/// Begins with the point of A nearest to B's centre, the point of B nearest to that, and the direction between.
void FeatureSearch::begin() {
  const Vec3 centre_b = b_.frame_point(core_centre(d_.b));
  w_.a = centre_b;
  const Vec3 between = w_.a - core_centre(d_.a);
  nearest_a_ = project(a_, w_.a, rounding_);
  w_.b = w_.a;
  nearest_b_ = project(b_, w_.b, rounding_);
  apart_ = !lost();
  w_.n = apart_ ? w_.b - w_.a : nearest_a_.surface != Surface::none ? centre_b - w_.a : between;
  w_.n = unit_or(w_.n, found_.n);
}

/// One more projection separates nearly all pairs that are well apart. True: the answer is known.
bool FeatureSearch::separated_by_projection(bool& common) {
  Vec3 p = w_.b;
  common = project(a_, p, rounding_).inside;
  if (common) return true;
  const Vec3 n = unit_or(w_.b - p, w_.n);
  const double closer = reach(n);
  if (!(closer < below_)) return false;
  found_.n = n, found_.h = closer;
  return true;
}

/// Finds nearest points of the bodies while B is moved away by `shift`, and the normal between them. False: one is
/// inside.
bool FeatureSearch::bring_near(int round, bool near, const Vec3& shift) {
  b_.centre = d_.pose.translation + shift;
  w_.b += shift;
  to_a(w_);
  // A hull's features are small, so the initial points should be closer: project once more.
  if ((is_hull(d_.a) || is_hull(d_.b)) && (round > 0 || near)) to_b(w_), to_a(w_);
  if (nearest_a_.surface == Surface::corner) to_b(w_);
  if (lost()) return false;
  w_.n = unit_or(w_.b - w_.a, w_.n);
  b_.centre = d_.pose.translation;
  w_.b -= shift;
  return true;
}

/// Finds the nearest points of the features on which the points lie; where a feature ends before, continues by
/// projections from its end.
bool FeatureSearch::meet(const Vec3& shift) {
  const bool from_a = d_.a.kind == ShapeKind::box || (is_hull(d_.a) && !is_hull(d_.b));
  NearestPoints points = w_;
  for (int turn = 0; turn < turns; ++turn) {
    points.n = w_.n;
    const bool between = nearest_points(a_, feature(a_, nearest_a_, rounding_), b_, feature(b_, nearest_b_, rounding_),
                                        rounding_, points);
    if (turn == 0) w_.b = points.b;
    const double length = points.n.norm();
    if (between && length > 0.5 && length < 2) {
      points.n /= length;
      return accept(points);
    }
    b_.centre += shift;
    points.b += shift;
    if (from_a) {
      to_b(points), to_a(points);
    } else {
      to_a(points), to_b(points);
    }
    b_.centre = d_.pose.translation;
    points.b -= shift;
    if (lost()) return false;
  }
  return false;
}

/// True if these are the nearest points of the bodies: the bodies' supports along the normal are not larger.
bool FeatureSearch::accept(const NearestPoints& points) {
  const double reached = reach(points.n);
  const Vec3 off = points.a - points.b - reached * points.n;
  if (!(off.squaredNorm() <= rounding_ * rounding_)) return false;
  found_.n = points.n, found_.h = reached;
  found_.point[0] = points.a, found_.point[1] = -points.b;
  found_.optimal = true;
  return true;
}

}  // namespace

bool have_features(const ConvexView& a, const ConvexView& b) {
  const auto has = [](const ConvexView& v) {
    return v.kind == ShapeKind::box || v.kind == ShapeKind::capsule || v.kind == ShapeKind::cylinder ||
           v.kind == ShapeKind::cone || (v.kind == ShapeKind::convex && has_rings(*v.hull));
  };
  return has(a) && has(b);
}

Support search_features(const MinkowskiDifference& d, double below, bool* common) {
  return FeatureSearch(d, below).run(common);
}

}  // namespace tandem
