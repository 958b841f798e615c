// The distance of a segment and a box, for capsules.
#include "boxes/segment_box.h"

#include "closed_forms/closed_forms.h"
#include "convex/gjk.h"
#include "tolerances.h"

namespace tandem {

double nearest_on_line(const Vec3& half, const Vec3& middle, const Vec3& along, double reach, double start) {
  // Newton's method on the derivative, which is piecewise linear and increasing: exact once it reaches the right one of
  // at most 7 pieces. If it leaves the bracket, the search continues at an end of a piece inside; without one the
  // bracket is a single piece.
  double lo = -reach, hi = reach, x = start, slope_lo = 0, slope_hi = 0;
  const auto end_of_piece = [&] {
    for (int i = 0; i < 3; ++i)
      for (const double side : {half[i], -half[i]})
        if (const double at = (side - middle[i]) / along[i]; at > lo && at < hi) return at;
    const double step = (hi - lo) / (slope_hi - slope_lo);
    return slope_hi < -slope_lo ? hi - step * slope_hi : lo - step * slope_lo;
  };
  bool seen_lo = false, seen_hi = false;
  for (int iteration = 0; iteration < 40; ++iteration) {
    double slope = 0, curvature = 0, squared = 0;
    for (int i = 0; i < 3; ++i) {
      const double at = middle[i] + x * along[i];
      const double over = at - std::clamp(at, -half[i], half[i]);
      slope += over * along[i];
      squared += over * over;
      curvature += over != 0 ? along[i] * along[i] : 0.0;
    }
    // To either end the distance changes by less than its rounding.
    if (slope * slope <= tolerance::line_slope2 * squared) return x;
    if (slope > 0)
      hi = x, slope_hi = slope, seen_hi = true;
    else
      lo = x, slope_lo = slope, seen_lo = true;
    double next = x - slope / curvature;
    if (std::abs(next - x) <= tolerance::line_step * reach) return x;
    if (seen_lo && seen_hi && !(next > lo && next < hi)) {
      next = end_of_piece();
      if (!(next > lo && next < hi)) return next;
    }
    next = std::clamp(next, lo, hi);
    if (next == x) return x;
    x = next;
  }
  return x;
}

namespace {

struct SegmentBoxPoints {
  Vec3 on_segment, on_box;
  bool inside;  ///< at neither end of the segment, or at one by rounding: the distance decreases inwards from it
};

SegmentBoxPoints nearest(const Vec3& half, const Vec3& centre, const Vec3& along, double reach) {
  const double x = nearest_on_line(half, centre, along, reach, std::clamp(-centre.dot(along), -reach, reach));
  const Vec3 p = centre + x * along, q = p.cwiseMax(-half).cwiseMin(half);
  return {p, q, std::abs(x) < reach || (p - q).dot(along) * x > 0};
}

/// The axis of largest separation: 0-2 faces, 3 + i: e_i x along.
struct SlabAxis {
  double separation;
  int index;
  Vec3 normal;
};

SlabAxis best_axis(const Vec3& half, const Vec3& centre, const Vec3& along, double reach) {
  SlabAxis best{std::abs(centre[0]) - half[0] - reach * std::abs(along[0]), 0, Vec3::UnitX()};
  for (int k = 1; k < 3; ++k) {
    const double s = std::abs(centre[k]) - half[k] - reach * std::abs(along[k]);
    if (s > best.separation) best = {s, k, Vec3::Unit(k)};
  }
  // An edge axis that coincides with a face normal must not win by its rounding.
  const double least = tolerance::tie * (half.sum() + reach);
  for (int i = 0; i < 3; ++i) {
    const int u = (i + 1) % 3, w = (i + 2) % 3;
    const double length2 = along[u] * along[u] + along[w] * along[w];
    if (!(length2 > tolerance::parallel_edges2)) continue;
    const double length = std::sqrt(length2), nu = -along[w] / length, nw = along[u] / length;
    const double s = std::abs(nu * centre[u] + nw * centre[w]) - half[u] * std::abs(nu) - half[w] * std::abs(nw);
    if (s > best.separation + least) {
      best = {s, 3 + i, Vec3::Zero()};
      best.normal[u] = nu;
      best.normal[w] = nw;
    }
  }
  if (best.normal.dot(centre) < 0) best.normal = -best.normal;
  return best;
}

/// The parameter of the segment's point that lies over the box's face or edge of the axis; false if there is none.
bool witness(const Vec3& half, const Vec3& centre, const Vec3& along, double reach, const SlabAxis& axis, double& x) {
  const double slack = tolerance::on_feature * (half.sum() + reach);
  if (axis.index >= 3) {
    const int i = axis.index - 3;
    // The point where the line of the edge passes the segment's, seen along the axis.
    Vec3 corner;
    for (int k = 0; k < 3; ++k) corner[k] = k == i ? 0.0 : std::copysign(half[k], axis.normal[k]);
    const Vec3 w = centre - corner, cross = Vec3::Unit(i).cross(along);
    x = w.cross(Vec3::Unit(i)).dot(cross) / cross.squaredNorm();
    if (!(std::abs(x) <= reach + slack)) return false;
    x = std::clamp(x, -reach, reach);
    const double on_edge = centre[i] + x * along[i];
    return std::abs(on_edge) <= half[i] + slack;
  }
  const double slope = along.dot(axis.normal);
  double lo = -reach, hi = reach;
  if (std::abs(slope) > tolerance::in_face) {
    lo = hi = -std::copysign(reach, slope);
  }
  for (int e = 0; e < 3; ++e) {
    if (e == axis.index) continue;
    if (lo < hi && std::abs(along[e]) * reach > slack) {
      const double s = (-half[e] - centre[e]) / along[e], q = (half[e] - centre[e]) / along[e];
      lo = std::max(lo, std::min(s, q));
      hi = std::min(hi, std::max(s, q));
    } else if (std::abs(centre[e] + lo * along[e]) > half[e] + slack) {
      return false;
    }
  }
  x = 0.5 * (lo + hi);
  return lo <= hi;
}

}  // namespace

double segment_box_distance2(const HalfSize& half, const Vec3& centre, const Vec3& along, double reach) {
  const SegmentBoxPoints n = nearest({half[0], half[1], half[2]}, centre, along, reach);
  return (n.on_segment - n.on_box).squaredNorm();
}

LocalAnswer segment_box_distance(const HalfSize& half_size, const Vec3& centre, const Vec3& along, double reach) {
  const Vec3 half{half_size[0], half_size[1], half_size[2]};
  const double size = half.sum() + reach;
  const SegmentBoxPoints near = nearest(half, centre, along, reach);
  Vec3 offset = near.on_segment - near.on_box;
  if (near.inside) offset -= offset.dot(along) * along;  // perpendicular, despite the rounding of so small a difference
  const double upper = offset.norm();
  LocalAnswer answer;
  answer.point_a = near.on_box;
  answer.point_b = near.on_segment;
  answer.signed_distance = upper;
  if (upper > 0.05 * size) {
    answer.normal = offset / upper;
    return answer;
  }
  // Near contact the direction between the points is noise where an axis is exact.
  const SlabAxis axis = best_axis(half, centre, along, reach);
  if (axis.separation > 0 && upper - axis.separation > tolerance::axis_rounding * size) {
    answer.normal = offset / upper;
    return answer;
  }
  answer.signed_distance = axis.separation;
  answer.normal = axis.normal;
  if (double x = 0; witness(half, centre, along, reach, axis, x)) {
    answer.point_b = centre + x * along;
    answer.point_a = answer.point_b - axis.separation * axis.normal;
  } else if (axis.separation > 0) {
    // The nearest points are opposite each other along another direction that separates as far to rounding.
    if ((offset - axis.separation * axis.normal).norm() <= tolerance::on_feature * size) return answer;
    answer.signed_distance = upper;
    answer.normal = offset / upper;
  } else {
    // The segment as a capsule of radius 0, its axis rotated to z.
    const ConvexView box = view_box(half_size);
    const ConvexView segment{
        .kind = ShapeKind::capsule, .param = {0, 2 * reach, 0, 0}, .vertices = {}, .hull = nullptr, .size = 2 * reach};
    RelativePose pose{Mat3::Identity(), centre};
    const Vec3 u = any_perpendicular(along);
    pose.rotation << u, along.cross(u), along;
    pair_points({box, segment, pose}, answer);
  }
  return answer;
}

}  // namespace tandem
