#include "round_pair.h"

#include <limits>

#include "round_depth.h"

namespace tandem {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// How far inside the tetrahedron the origin lies: near its faces it may do so by rounding alone.
double depth_in(const Simplex& s) {
  double depth = infinity;
  for (int i = 0; i < 4; ++i) {
    const Vec3 &a = s.p[i].w, &b = s.p[(i + 1) % 4].w, &c = s.p[(i + 2) % 4].w;
    const Vec3 n = (b - a).cross(c - a);
    const double length = n.norm();
    depth = std::min(depth, length > 0 ? std::abs(n.dot(a)) / length : 0.0);
  }
  return depth;
}

Vec3 inside(const ConvexView& v) { return v.hull != nullptr ? v.hull->inside : core_centre(v); }

Vec3 between_centres(const MinkowskiDifference& d) {
  return d.pose.rotation * inside(d.b) + d.pose.translation - inside(d.a);
}

Vec3 direction(const Vec3& v) {
  const double length = v.norm();
  return length > 0 ? Vec3(v / length) : Vec3::UnitX();
}

}  // namespace

LocalAnswer round_signed_distance(const MinkowskiDifference& d, const Vec3* start, double beyond) {
  const RoundPair pair(d);
  const double ra = core_radius(d.a), rb = core_radius(d.b), below = -beyond - ra - rb;
  const Vec3 between = between_centres(d);
  Support s;
  s.n = direction(between);
  s.h = s.n.dot(pair.support(s.n));
  // So deep in each other, the way between the centres is no better to begin with than any.
  const bool deep = s.h > between.norm();
  if (!deep) {
    if (start != nullptr) {
      // Apart, there is one minimum, whichever way it is reached.
      const Vec3 m = start->normalized();
      const double h = m.dot(pair.support(m));
      if (h < 0 && h < s.h) s.n = m;
    }
    s = walk(pair, s.n, below);
  }
  if (s.h < below) {
    LocalAnswer apart;
    apart.signed_distance = -s.h - ra - rb;
    apart.normal = s.n;
    return apart;
  }
  double gap = 0;
  if (s.h >= 0) {
    const Depth depth = least_depth(pair, s, !deep);
    s = depth.best;
    gap = depth.gap;
  }
  if (!s.optimal) gap = std::max(gap, (s.point[0] + s.point[1] - s.h * s.n).norm());
  LocalAnswer answer;
  answer.normal = s.n;
  answer.signed_distance = -s.h - ra - rb;
  answer.point_a = s.point[0] + ra * s.n;
  answer.point_b = -s.point[1] - rb * s.n;
  answer.gap = gap <= 1e-13 * pair.scale ? 0 : gap;
  return answer;
}

bool round_collide(const MinkowskiDifference& d, double tolerance) {
  const RoundPair pair(d);
  const double rounding = core_radius(d.a) + core_radius(d.b);
  const Vec3 n = direction(between_centres(d));
  if (n.dot(pair.support(n)) < -rounding - 4 * epsilon * pair.scale) return false;
  const GjkResult r = gjk(d, std::max(tolerance, 1e-14), rounding, rounding);
  if (r.end == GjkResult::End::inside && depth_in(r.simplex) > 1e-10 * pair.scale) return true;
  if (r.lower > rounding) return false;
  if (r.end == GjkResult::End::separated && r.upper <= rounding) return true;
  return round_signed_distance(d).signed_distance <= 0;
}

}  // namespace tandem
