// GJK (Gilbert, Johnson, Keerthi 1988): the distance of two convex cores, with bounds.
#include "convex/gjk.h"

#include "convex/descent_kernel.h"
#include "shapes/triangle_height.h"
#include "tolerances.h"

namespace tandem {
namespace {

constexpr int max_iterations = 96;

/// The direction of v, made perpendicular to the edges of the simplex: the difference of two nearly equal points is
/// exact only in this respect; for round shapes the edges are exact to the rounding of points.
Vec3 square_to_edges(const MinkowskiDifference& d, const Simplex& s, const Vec3& v) {
  // Points of round shapes have no vertex numbers.
  const auto edge = [&, polytopes = d.polytopes()](int to, int from) {
    return polytopes ? d.edge(s.p[to], s.p[from]) : Vec3(s.p[to].w - s.p[from].w);
  };
  Vec3 n = v;
  if (s.count == 2) {
    const Vec3 e = edge(1, 0);
    const double e2 = e.squaredNorm();
    for (int i = 0; i < 2 && e2 > 0; ++i) n -= (n.dot(e) / e2) * e;
  } else if (s.count == 3) {
    n = normal_of(edge(1, 0), edge(2, 1), edge(0, 2));
    if (n.dot(v) < 0) n = -n;
  }
  const double length = n.norm();
  return length > 0 ? unit(n, length) : unit(v);
}

/// True if the simplex contains the point; points of round shapes have no vertex numbers.
bool has(const Simplex& s, const MinkowskiPoint& p, bool polytopes) {
  return std::any_of(s.p, s.p + s.count, [&](const MinkowskiPoint& q) {
    return polytopes ? p.vertex_a == q.vertex_a && p.vertex_b == q.vertex_b : p.w == q.w;
  });
}

/// Repeats GJK's last steps where rounding may have determined the fast result (for polytopes also where the bounds
/// disagree), and where the direction of the lower bound is not that of the point found: from afar, another one with as
/// good a bound. The upper bound is the length of a point of the simplex; the lower bound is a separation along it, or
/// along a direction perpendicular to the simplex's edges. Sets the weights.
void refine(const MinkowskiDifference& d, const DescentLimits& limits, GjkResult& r) {
  constexpr int most_steps = 16;
  const auto close = [&limits](double upper) { return 2 * limits.rounding + limits.tolerance * upper; };
  const bool polytopes = d.polytopes();
  NearestOnSimplex n = nearest_to_origin(r.simplex);
  // An effect of rounding: simplices that contain the origin do not get here.
  if (n.inside) n = nearest_on_sides(r.simplex);
  if ((n.v + r.upper * r.direction).squaredNorm() <= 16 * limits.rounding * limits.rounding &&
      (!polytopes || r.upper - r.lower <= close(r.upper)))
    return keep_nearest(r.simplex, n);
  Simplex s = r.simplex;
  for (int step = 0; step < most_steps && !n.inside; ++step, n = nearest_to_origin(s)) {
    const double upper = std::sqrt(n.squared);
    // At a large distance a sideways step changes the direction, but no digit of the length.
    if (step > 0 && !(upper <= r.upper + limits.rounding)) return;
    keep_nearest(s, n);
    r.simplex = s;
    r.v = n.v;
    r.upper = upper;
    bool known = true;
    const auto try_along = [&](const Vec3& along) {
      if (along.isZero(0)) return false;
      const MinkowskiPoint p = d.support(-along);
      const double lower = along.dot(p.w);
      const bool met = upper - lower <= close(upper);
      if (met || lower > r.lower) r.lower = std::max(r.lower, lower), r.direction = -along;
      if (!has(s, p, polytopes)) known = false, s.p[s.count] = p;
      return met;
    };
    if (try_along(unit(n.v)) || try_along(square_to_edges(d, s, n.v)) || known) return;
    ++s.count;
  }
}

/// GJK's loop where one of the shapes is round.
void descend_round(const MinkowskiDifference& d, const DescentLimits& limits, GjkResult& r) {
  Vec3& v = r.v;
  Simplex& s = r.simplex;
  r.upper = infinity;
  r.lower = -r.upper;
  double length = v.norm();
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    const MinkowskiPoint p = d.support(-v);
    const double along = v.dot(p.w) / length;
    if (along > r.lower - limits.rounding) r.lower = std::max(r.lower, along), r.direction = -v / length;
    if (r.lower > limits.beyond ||
        (s.count > 0 && r.upper - r.lower <= limits.tolerance * std::min(r.upper, limits.size) + limits.rounding))
      break;
    bool known = false;
    for (int i = 0; i < s.count; ++i) known = known || p.w == s.p[i].w;
    if (known) break;
    s.p[s.count++] = p;
    NearestOnSimplex n = nearest_to_origin(s);
    // With a separating direction known, the simplex cannot contain the origin: it is flat.
    if (n.inside && r.lower > 2 * limits.rounding) n = nearest_on_sides(s);
    if (n.inside) {
      r.end = GjkResult::End::inside;
      r.upper = 0;
      return;
    }
    if (s.count > 1 && !(n.squared < v.squaredNorm())) {
      --s.count;
      break;
    }
    v = n.v;
    keep_nearest(s, n);
    length = v.norm();
    r.upper = length;
    if (r.upper <= std::max(limits.within, limits.rounding)) break;
  }
}

}  // namespace

GjkResult descend(const MinkowskiDifference& d, double tolerance, double beyond, double within, const Vec3* start,
                  double at_once) {
  GjkResult r;
  Vec3& v = r.v;
  v = start != nullptr ? -*start : Vec3(core_centre(d.a) - d.pose.rotation * core_centre(d.b) - d.pose.translation);
  if (const double length = v.norm(); !(length > tolerance::shortest_squared))
    v = length > 0 ? unit(v, length) : Vec3(-Vec3::UnitX());
  const bool polytopes = d.polytopes();
  const double scale = d.scale();
  const double rounding = 2 * epsilon * scale;
  const DescentLimits limits{tolerance, beyond, within, at_once, rounding, scale, larger(d)};
  r.end = GjkResult::End::near;
  if (polytopes)
    descent_kernel()(d, limits, r);
  else
    descend_round(d, limits, r);
  // With a separating direction known, the simplex cannot contain the origin: it is flat.
  if (polytopes && r.end == GjkResult::End::inside && r.lower > 2 * rounding)
    r.end = GjkResult::End::near, r.upper = r.simplex.p[0].w.norm();
  if (r.end == GjkResult::End::inside || r.simplex.count == 0) return r;
  if (!(r.lower > beyond)) refine(d, limits, r);
  // For polytopes a result certified to rounding needs no confirmation.
  const double near =
      polytopes
          ? (r.upper - r.lower <= 8 * rounding + tolerance * r.upper ? 16 * rounding : tolerance::near_surface * scale)
          : tolerance::near_surface * scale;
  r.end = r.upper > near ? GjkResult::End::separated : GjkResult::End::near;
  return r;
}

GjkResult gjk(const MinkowskiDifference& d, double tolerance) {
  GjkResult r = descend(d, tolerance, infinity, -infinity, nullptr);
  if (r.simplex.count > 0) set_weights(r.simplex);
  return r;
}

void pair_points(const MinkowskiDifference& d, LocalAnswer& answer) {
  const double scale = d.scale();
  MinkowskiDifference apart = d;
  if (d.polytopes()) {
    // Rounding of the distance leaves the points undetermined sideways by the square root of its product with the
    // distance: move the shapes less far apart where that is too much.
    double least = infinity;
    for (const double out :
         {tolerance::far_apart * scale, tolerance::near_apart * scale, tolerance::least_apart * scale}) {
      apart.pose.translation = d.pose.translation + (out - answer.signed_distance) * answer.normal;
      const GjkResult r = gjk(apart, tolerance::ends_on_polytopes);
      LocalAnswer there;
      set_points(r.simplex, there);
      const double sideways = (there.point_a - there.point_b + out * answer.normal).norm();
      if (!(sideways < least)) continue;
      least = sideways;
      answer.point_a = there.point_a, answer.point_b = there.point_b;
      answer.point_b -= (out - answer.signed_distance) * answer.normal;
      if (sideways <= tolerance::place_rounding * scale) break;
    }
    return;
  }
  const double out = tolerance::moved_apart * scale;
  for (int round = 0;; ++round) {
    apart.pose.translation = d.pose.translation + (out - answer.signed_distance) * answer.normal;
    const GjkResult r = gjk(apart, tolerance::ends_on_polytopes);
    answer.point_a.setZero();
    for (int i = 0; i < r.simplex.count; ++i) answer.point_a += r.simplex.weight[i] * r.simplex.p[i].a;
    if (round == 8 || !(r.upper > 0)) break;
    // Outside a curved surface, the direction to it approaches the normal of least depth.
    const Vec3 n = -r.v / r.upper;
    const double change = (n - answer.normal).squaredNorm();
    const double depth = n.dot(d.support(n).w);
    if (!(depth < -answer.signed_distance)) break;
    answer.signed_distance = -depth;
    answer.normal = n;
    if (change < tolerance::stopped_turning2) break;
  }
  answer.point_b = answer.point_a + answer.signed_distance * answer.normal;
}

}  // namespace tandem
