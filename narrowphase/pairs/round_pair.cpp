// Pairs with a cylinder, cone or ellipsoid: the order of methods.
#include "pairs/round_pair.h"

#include <optional>

#include "closed_forms/closed_forms.h"
#include "closed_forms/surface_distance.h"
#include "convex/portal.h"
#include "convex/projection.h"
#include "pairs/gjk_pair.h"
#include "round/feature_search.h"
#include "round/round_depth.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// True if the point of one shape where the other penetrates most is inside the other, beyond rounding.
bool share_a_point(const MinkowskiDifference& d, const Support& s, double scale) {
  const double rounding = 64 * epsilon * scale;
  Vec3 a = s.point[0] + core_radius(d.a) * s.n, b = -s.point[1] - core_radius(d.b) * s.n;
  a = d.pose.rotation.transpose() * (a - d.pose.translation);
  return move_into(d.a, b, rounding).inside || move_into(d.b, a, rounding).inside;
}

Vec3 inside(const ConvexView& v) { return v.hull != nullptr ? v.hull->inside : core_centre(v); }

Vec3 between_centres(const MinkowskiDifference& d) {
  return d.pose.rotation * inside(d.b) + d.pose.translation - inside(d.a);
}

/// The distance of a point near a cylinder, cone or ellipsoid from its surface, in its frame; of an ellipsoid to first
/// order.
double off_surface(const ConvexView& v, const Vec3& p) {
  if (v.kind != ShapeKind::ellipsoid) return std::abs(point_distance(v, p).signed_distance);
  const Vec3 radii{v.param[0], v.param[1], v.param[2]}, q = p.cwiseQuotient(radii);
  const double k = q.norm(), gradient = q.cwiseQuotient(radii).norm();
  return gradient > 0 ? std::abs(k * (k - 1) / gradient) : infinity;
}

/// Of separated bodies replaces a cylinder's or cone's point by the foot of the other body's point or of its support
/// along n, and n by the direction to it: at the rim of a disc the last digits of n decide between points along it.
/// False, without any change, if neither foot bounds the distance as closely as before, to rounding.
bool project(const RoundPair& pair, int which, Support& s) {
  const RoundBody& body = pair.body[which];
  if (!(s.h < 0) || !body.has_circle()) return false;
  const Vec3 others[2] = {s.point[1 - which], pair.body[1 - which].support(s.n)};
  const double rounding = 64 * epsilon * pair.scale, highest = s.h + rounding;
  double least = std::max(doubt(s), rounding);
  bool any = false;
  for (const Vec3& other : others) {
    const PointDistance foot = point_distance(body.view(), body.axes().transpose() * (-other - body.centre()));
    if (!(foot.signed_distance > 0)) continue;
    Support found = s;
    found.point[which] = body.centre() + body.axes() * foot.nearest;
    found.point[1 - which] = other;
    found.n = unit(body.axes() * foot.normal);
    found.h = found.n.dot(pair.support(found.n));
    // Along the old normal they are as far apart as s.h says.
    if (!(found.h < 0 && found.h <= highest && doubt(found) <= least)) continue;
    least = doubt(found);
    s = found;
    any = true;
  }
  return any;
}

/// The point of a shape's core nearest to one outside, in its frame; not of hulls.
Vec3 nearest_of(const ConvexView& v, const Vec3& p) {
  if (v.kind == ShapeKind::ellipsoid) {
    const Vec3 radii{v.param[0], v.param[1], v.param[2]}, scaled = radii.cwiseProduct(ellipsoid_normal(radii, p));
    return radii.cwiseProduct(scaled) / scaled.norm();
  }
  const PointDistance foot = point_distance(v, p);
  return foot.nearest - core_radius(v) * foot.normal;
}

bool is_round(const RoundBody& body) { return body.kind() == ShapeKind::ellipsoid || body.has_circle(); }

/// Moves both points, each to the nearest from the other, until they stay, a flat body's first: a round body's is the
/// only one that supports along n, a flat one has a face or an edge of them. Of bodies as short or thin as the accuracy
/// of n, as a short capsule and a needle, both may be off. Of bodies that overlap, B counts as moved out by h n. Where
/// the points then are h n apart, to `open`, n and h stay; else, of separated bodies, n becomes the direction between
/// the points, if the support along it fits them better than h n did. Else nothing changes.
void project_in_turn(const RoundPair& pair, double open, Support& s) {
  constexpr int most_turns = 64;
  const double still = 16 * epsilon * pair.scale;
  for (const RoundBody& body : pair.body)
    if (body.kind() == ShapeKind::convex) return;
  const Vec3 out = std::max(0.0, s.h) * s.n;
  const int first = is_round(pair.body[0]) ? 1 : 0;
  Support found = s;
  for (int turn = 0; turn < most_turns; ++turn) {
    double moved = 0;
    for (const int which : {first, 1 - first}) {
      const RoundBody& body = pair.body[which];
      const Vec3 other = body.axes().transpose() * (out - found.point[1 - which] - body.centre());
      const Vec3 point = body.centre() + body.axes() * nearest_of(body.view(), other);
      moved = std::max(moved, (point - found.point[which]).norm());
      found.point[which] = point;
    }
    if (moved <= still) break;
  }
  if (residual(found) <= open) {
    s = found;
    return;
  }
  if (!(s.h < 0)) return;
  found.n = unit(-found.point[0] - found.point[1]);
  found.h = found.n.dot(pair.support(found.n));
  if (!(found.h < 0 && doubt(found) < residual(s))) return;
  found.h = std::min(found.h, s.h);
  s = found;
}

/// Makes the points h n apart. The last digit of n moves the point of a flat ellipsoid by that times its radius of
/// curvature, and that of a disc along it. The other body's point gives it to all digits: projected, with n and h, or
/// by h n where that leads to the surface.
void straighten_points(const RoundPair& pair, Support& s) {
  const double open = tolerance::place_rounding * pair.scale, rounding = 64 * epsilon * pair.scale;
  for (const int which : {0, 1}) {
    const RoundBody& body = pair.body[which];
    if (residual(s) <= open || project(pair, which, s)) return;
    const Vec3 derived = s.h * s.n - s.point[1 - which];
    if (is_round(body) && off_surface(body.view(), body.axes().transpose() * (derived - body.centre())) <= rounding)
      s.point[which] = derived;
  }
  if (residual(s) > open) project_in_turn(pair, open, s);
}

/// Newton's method may end at an edge of h with the right normal and one end of the other body's edge as the point.
/// Takes GJK's points and normal if they bound the distance more closely: the distance of the points from above, the
/// support along the normal from below. Returns the difference of the bounds, which was `gap`.
double try_gjk(const MinkowskiDifference& d, const RoundPair& pair, Support& s, double gap) {
  const LocalAnswer by_gjk = gjk_signed_distance(d, 0, &s.n);
  Support found;
  found.n = by_gjk.normal;
  found.h = found.n.dot(pair.support(found.n));
  found.point[0] = by_gjk.point_a - core_radius(d.a) * found.n;
  found.point[1] = -by_gjk.point_b - core_radius(d.b) * found.n;
  if (!(found.h < 0 && doubt(found) < gap)) return gap;
  s = found;
  return doubt(s);
}

Vec3 direction(const Vec3& v) {
  const double length = v.norm();
  return length > 0 ? unit(v, length) : Vec3::UnitX();
}

}  // namespace

LocalAnswer round_signed_distance(const MinkowskiDifference& d, const Vec3* start, double beyond) {
  const RoundPair pair(d);
  const double ra = core_radius(d.a), rb = core_radius(d.b), below = -beyond - ra - rb;
  const Vec3 between = between_centres(d);
  Support s;
  s.n = direction(between);
  s.h = s.n.dot(pair.support(s.n));
  // For such deep overlaps the line of centres is no better a start than any.
  const bool deep = s.h > between.norm();
  if (!deep) {
    if (start != nullptr) {
      // Separated shapes have a single minimum, whatever the start.
      const double h = start->dot(pair.support(*start));
      if (h < 0 && h < s.h) s.n = *start;
    }
    if (have_features(d.a, d.b)) s = search_features(d, below);
    if (!s.optimal && s.h >= below) s = minimize(pair, s.n, below);
  }
  if (s.h < below) return farther_than(beyond, -s.h, ra, rb, s.n);
  double gap = 0;
  if (s.h >= 0) {
    const Depth depth = least_depth(pair, s, !deep);
    s = depth.best;
    gap = depth.gap;
  }
  if (!s.optimal) gap = std::max(gap, doubt(s));
  if (s.h < 0 && gap > tolerance::no_gap * pair.scale) gap = try_gjk(d, pair, s, gap);
  // What seemed a deep overlap from the centres, and has no certain depth, may be none.
  if (deep && gap > tolerance::no_gap * pair.scale) {
    const Support descended = minimize(pair, direction(search_portal(d).normal), below);
    if (descended.h < 0) s = descended, gap = s.optimal ? 0 : doubt(s);
  }
  straighten_points(pair, s);
  if (s.h < below) return farther_than(beyond, -s.h, ra, rb, s.n);
  LocalAnswer answer;
  answer.normal = s.n;
  answer.signed_distance = -s.h - ra - rb;
  answer.point_a = s.point[0] + ra * s.n;
  answer.point_b = -s.point[1] - rb * s.n;
  answer.gap = gap <= tolerance::no_gap * pair.scale ? 0 : gap;
  return answer;
}

bool round_collide(const MinkowskiDifference& d) {
  const double scale = rounding_scale(d), below = -core_radius(d.a) - core_radius(d.b) - 4 * epsilon * scale;
  const auto by_features = [&]() -> std::optional<bool> {
    bool common = false;
    const Support s = search_features(d, below, &common);
    if (common) return true;
    if (s.h < below) return false;
    if (s.optimal && share_a_point(d, s, scale)) return true;
    return std::nullopt;
  };
  // A hull's features take longer to find than a portal search.
  const bool features = have_features(d.a, d.b), first = d.a.hull == nullptr && d.b.hull == nullptr;
  if (features && first)
    if (const auto collide = by_features()) return *collide;
  const PortalResult portal = search_portal(d);
  if (portal.verdict != PortalResult::Verdict::open) return portal.verdict == PortalResult::Verdict::overlapping;
  if (features && !first)
    if (const auto collide = by_features()) return *collide;
  const Support s = minimize(RoundPair(d), direction(portal.normal), below);
  if (s.h < below) return false;
  if (share_a_point(d, s, scale)) return true;
  return round_signed_distance(d).signed_distance <= 0;
}

}  // namespace tandem
