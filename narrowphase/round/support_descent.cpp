// Local minima of h by Newton's method, and by a sequence of convex problems.
#include "round/support_descent.h"

#include "convex/gjk.h"
#include "round/newton_descent.h"
#include "tolerances.h"

namespace tandem {
namespace {

// Both relative to RoundPair::scale.

/// The rounding error of h by supports: sums of some ten products of rounded numbers.
constexpr double height_rounding = 64 * epsilon;
/// The distance from h n up to which two points confirm a distance to rounding: in addition to h's error they have that
/// of n, times radii of curvature. With a larger one wrong distances were accepted; with a smaller one descents that
/// have arrived continue in `settle`.
constexpr double meeting = 512 * epsilon;

/// Rotates n to the difference of the two points: an error of n shows to first order in the points' distance from h n,
/// but only to second order in their distance and in h.
void straighten(const RoundPair& pair, Support& s) {
  const double rounding = height_rounding * pair.scale;
  const Vec3 p = s.point[0] + s.point[1];
  const double off = (p - s.h * s.n).squaredNorm(), length = p.norm();
  if (off <= rounding * rounding || !(length > 0)) return;
  const Vec3 n = (s.h < 0 ? -p : p) / length;
  const double h = n.dot(pair.support(n));
  if (h <= s.h + rounding && (p - h * n).squaredNorm() < off) s.n = n, s.h = h;
}

/// True if the points confirm h n to rounding.
bool meets(const RoundPair& pair, const Support& s) { return residual(s) <= meeting * pair.scale; }

}  // namespace

Support minimize(const RoundPair& pair, const Vec3& n, double below) {
  constexpr int tries = 4;
  const double rounding = height_rounding * pair.scale;
  Support s;
  s.n = n;
  s.h = infinity;
  const auto run_newton = [&] {
    for (int i = 0; i < tries; ++i) {
      NewtonDescent newton(pair, s.n, below);
      Support end = newton.run();
      // Where circles of the two bodies intersect, or cells are smaller than rounding, a piece may be missed: start
      // again, or, if that has led uphill, stop.
      const double reached = end.h;
      end.h = end.n.dot(pair.support(end.n));
      if (end.h > newton.started() + rounding) return false;
      s = end;
      if (s.h - reached <= rounding) break;
    }
    straighten(pair, s);
    return s.h < below || meets(pair, s);
  };
  const auto found = [&](Support best) {
    const double open = tolerance::descent_accuracy * pair.scale;
    best.optimal = doubt(best) <= (best.h < 0 ? rounding : open) && residual(best) <= open;
    return best;
  };
  if (run_newton()) return found(s);
  const Support descended = s, settled = settle(pair, s.n, below);
  const auto better = [&](const Support& p, const Support& q) {
    return p.h < q.h - rounding || (p.h <= q.h + rounding && residual(p) < residual(q));
  };
  if (settled.h < below || meets(pair, settled)) return found(settled);
  // Newton's method gives the last digits.
  s = settled;
  run_newton();
  if (!better(s, settled)) s = settled;
  return found(better(descended, s) ? descended : s);
}

double residual(const Support& s) { return (s.point[0] + s.point[1] - s.h * s.n).norm(); }

double doubt(const Support& s) { return s.h < 0 ? (s.point[0] + s.point[1]).norm() + s.h : residual(s); }

Support settle(const RoundPair& pair, const Vec3& n, double below) {
  constexpr int rounds = 8;
  const double rounding = height_rounding * pair.scale;
  MinkowskiDifference moved = pair.difference;
  Support best;
  best.n = n;
  double least = infinity;  // |p - h n| of the best
  const auto consider = [&](const Vec3& n, double h, const Vec3& a, const Vec3& b) {
    const double off = (a + b - h * n).norm();
    const bool lower = h < best.h - rounding || least == infinity;
    if (!lower && !(h <= best.h + rounding && off < least)) return;
    best.n = n, best.h = h, best.point[0] = a, best.point[1] = b;
    least = off;
  };
  // The nearer, the less the last digits of the direction matter for the end point, and the less exact the direction
  // is.
  for (const double out : {tolerance::moved_apart * pair.scale, tolerance::far_apart * pair.scale,
                           tolerance::round_least_apart * pair.scale}) {
    Vec3 from = best.n;
    double h = from.dot(pair.support(from));
    for (int round = 0; round < rounds; ++round) {
      const double shift = std::max(0.0, h + out);
      moved.pose.translation = pair.difference.pose.translation + shift * from;
      const GjkResult r = gjk(moved, tolerance::ends_at_standstill);
      // The point of each body, whatever the rounding of their difference.
      Vec3 a = Vec3::Zero(), b = shift * from;
      for (int i = 0; i < r.simplex.count; ++i) {
        a += r.simplex.weight[i] * r.simplex.p[i].a;
        b += r.simplex.weight[i] * (r.simplex.p[i].w - r.simplex.p[i].a);
      }
      consider(from, h, a, b);
      if (!(r.upper > 0)) break;
      const Vec3 to = -r.v / r.upper;
      h = to.dot(pair.support(to));
      consider(to, h, a, b);
      if (best.h < below || meets(pair, best) || shift == 0 || h > best.h + rounding) break;
      from = to;
    }
    if (best.h < below || meets(pair, best)) break;
  }
  return best;
}

}  // namespace tandem
