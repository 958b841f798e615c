// The nearest points of two features, by closed forms and Newton's method.
#include "round/feature_points.h"

#include <algorithm>
#include <cmath>

#include "shapes/unit_vector.h"

namespace tandem {
namespace {

constexpr int newton_steps = 8;
using tolerance::newton_end;  ///< radians: the step after one this small changes no digit

/// Rotates (c, s) by an angle of at most about 1.
void turn(double& c, double& s, double angle) {
  const double t = 0.5 * angle, k = 1 / (1 + t * t), x = (1 - t * t) * k, y = 2 * t * k;
  const double turned = x * c - y * s;
  s = x * s + y * c;
  c = turned;
}

bool within(const Feature& f, double t, double rounding) { return t >= f.low - rounding && t <= f.high + rounding; }

/// The unit vector along v or -v, whichever has a product >= 0 with n.
Vec3 unit_along(const Vec3& v, const Vec3& n) { return unit_or(v.dot(n) < 0 ? Vec3(-v) : v, n); }

/// The generator of a cone where its normal leans from the axis towards `aside`: unit, perpendicular to the axis. Not
/// from the normal: a flat cone's is the axis but for the cone's height, and their difference has lost as many digits.
Feature generator(const Feature& side, const Vec3& aside) {
  Feature line = side;
  line.surface = Surface::straight;
  line.axis = side.sine * aside - side.cosine * side.axis;
  return line;
}

/// From a corner to any feature but a face.
bool corner_to_feature(const Vec3& corner, const Feature& f, double rounding, NearestPoints& w) {
  w.a = corner;
  const Vec3 from = corner - f.point;
  if (f.surface == Surface::corner) {
    w.b = f.point;
    w.n = unit_along(from, w.n);
    return true;
  }
  if (f.surface == Surface::circle) {
    const double x = from.dot(f.u), y = from.dot(f.v), rho = std::sqrt(x * x + y * y);
    if (!(rho > 0)) return false;
    w.b = f.point + (f.radius / rho) * (x * f.u + y * f.v);
    w.n = unit_along(corner - w.b, w.n);
    return true;
  }
  const double up = from.dot(f.axis);
  const Vec3 off = from - up * f.axis;
  if (f.surface == Surface::side) {
    const Vec3 aside = unit_along(off, -w.n), out = f.cosine * aside + f.sine * f.axis;
    const Feature line = generator(f, aside);
    const double down = from.dot(line.axis);
    w.b = f.point + down * line.axis;
    w.n = -out;
    return within(f, down, rounding);
  }
  w.n = unit_along(off, w.n);
  w.b = f.point + std::clamp(up, f.low, f.high) * f.axis - f.radius * w.n;
  return within(f, up, rounding);
}

/// Two lines; `n` is perpendicular to both.
bool line_to_line(const Feature& a, const Feature& b, const Vec3& n, double rounding, NearestPoints& w) {
  const Vec3 between = b.point - a.point, across = a.axis.cross(b.axis);
  const double det = across.squaredNorm();
  if (!(det > tolerance::crossing2)) return false;
  const double s = between.cross(b.axis).dot(across) / det, t = between.cross(a.axis).dot(across) / det;
  w.n = n;
  w.a = a.point + std::clamp(s, a.low, a.high) * a.axis + a.radius * n;
  w.b = b.point + std::clamp(t, b.low, b.high) * b.axis - b.radius * n;
  return within(a, s, rounding) && within(b, t, rounding);
}

/// Two lines, or generators of cones: their common normal is on a circle about each axis, and points from a to b.
bool straight_to_straight(const Feature& a, const Feature& b, double rounding, NearestPoints& w) {
  const Vec3 across = a.axis.cross(b.axis);
  const double det = across.squaredNorm();
  if (!(det > tolerance::crossing2)) return false;
  if (a.surface == Surface::straight && b.surface == Surface::straight) {
    const Vec3 n = std::copysign(1 / std::sqrt(det), across.dot(w.n)) * across;
    return line_to_line(a, b, n, rounding, w);
  }
  // n = x a + y b + z (a x b) with n a = sin_a and n b = -sin_b. Flat cones have sines near 1: differences of products
  // of these are computed from cosines and by `opposite`, 1 + a b, which keep their digits.
  const double d = a.axis.dot(b.axis), cosines = a.cosine * b.cosine;
  const double opposite = d < 0 ? det / (1 - d) : 1 + d;
  const double a2 = a.cosine * a.cosine, b2 = b.cosine * b.cosine, sum = a.sine + b.sine;
  // The difference of the sines: steep cones have cosines near 1.
  const double sines = sum < 1 ? a.sine - b.sine : (b2 - a2) / sum;
  const double lean = opposite - (a2 + b2 - a2 * b2) / (1 + a.sine * b.sine);
  const double x = (sines + opposite * b.sine) / det, y = (sines - opposite * a.sine) / det;
  const double rest = (cosines - lean) * (cosines + lean);
  if (!(rest > 0)) {
    // One of the normals is limited to a cone: b's, if it is one.
    const bool in_b = b.surface == Surface::side;
    const Feature& side = in_b ? b : a;
    const Vec3 p = in_b ? w.b : w.a, from = p - side.point;
    const Vec3 down = from.dot(side.axis) < 0 ? unit(from) : Vec3(-side.axis);
    const double slope = down.dot(in_b ? w.n : Vec3(-w.n));
    w.a = w.b = side.point + (slope < 0 ? side.high : 0.0) * down;
    return false;
  }
  const Vec3 z = std::copysign(std::sqrt(rest) / det, across.dot(w.n)) * across;
  const Vec3 n = x * a.axis + y * b.axis + z;
  const Feature in_a = a.surface == Surface::side ? generator(a, unit_or(z - y * a.axis.cross(across), n)) : a;
  const Feature in_b = b.surface == Surface::side ? generator(b, unit_or(-z - x * b.axis.cross(across), n)) : b;
  return line_to_line(in_a, in_b, n, rounding, w);
}

/// From a circle to a line, or to a cone's lateral surface.
bool circle_to_line(Feature circle, const Feature& line, double rounding, NearestPoints& w) {
  const bool side = line.surface == Surface::side;
  const Vec3 from = circle.point - line.point;
  const double r = circle.radius, ue = circle.u.dot(line.axis), ve = circle.v.dot(line.axis), up = from.dot(line.axis);
  const double a = from.dot(circle.u) - up * ue, b = from.dot(circle.v) - up * ve;
  const double uu = 1 - ue * ue, uv = -ue * ve, vv = 1 - ve * ve, off2 = from.squaredNorm() - up * up;
  double &c = circle.c, &s = circle.s;
  bool found = false;
  for (int step = 0; step < newton_steps && !found; ++step) {
    // Half the squared distance from the line as a function of the angle.
    const double x = a + r * (c * uu + s * uv), y = b + r * (c * uv + s * vv);
    double first = r * (c * y - s * x), second = r * (r * (s * s * uu - 2 * s * c * uv + c * c * vv) - c * x - s * y);
    if (side) {
      const double rho2 = off2 + 2 * r * (c * a + s * b) + r * r * (c * c * uu + 2 * c * s * uv + s * s * vv);
      if (!(rho2 > 0)) return false;
      const double k = line.cosine / std::sqrt(rho2);
      second = k * (second - first * first / rho2) - line.sine * r * (c * ue + s * ve);
      first = k * first + line.sine * r * (c * ve - s * ue);
    }
    if (!(second > 0)) return false;
    const double angle = std::clamp(-first / second, -0.7, 0.7);
    turn(c, s, angle);
    found = std::abs(angle) < newton_end;
  }
  w.a = circle.point + r * (c * circle.u + s * circle.v);
  const Vec3 on = w.a - line.point;
  Feature straight = line;
  Vec3 out = on - on.dot(line.axis) * line.axis;
  if (side) {
    const Vec3 aside = unit(out);
    out = line.cosine * aside + line.sine * line.axis;
    straight = generator(line, aside);
  } else {
    // Perpendicular to both: where they nearly touch, their difference is noise.
    const Vec3 across = line.axis.cross(c * circle.v - s * circle.u);
    out = unit_along(across.squaredNorm() > tolerance::clearly_crossing2 ? across : out, -w.n);
  }
  const double t = on.dot(straight.axis);
  w.b = straight.point + std::clamp(t, straight.low, straight.high) * straight.axis + (side ? 0 : line.radius) * out;
  w.n = -out;
  return found && within(straight, t, rounding);
}

bool circle_to_circle(Feature a, Feature b, NearestPoints& w) {
  const Vec3 between = a.point - b.point;
  bool found = false;
  for (int step = 0; step < newton_steps && !found; ++step) {
    const Vec3 out_a = a.c * a.u + a.s * a.v, out_b = b.c * b.u + b.s * b.v;
    const Vec3 along_a = a.c * a.v - a.s * a.u, along_b = b.c * b.v - b.s * b.u;
    const Vec3 d = between + a.radius * out_a - b.radius * out_b;
    // The gradient of half the squared distance, over both radii.
    const double ga = along_a.dot(d), gb = -along_b.dot(d);
    const double aa = a.radius - out_a.dot(d), bb = b.radius + out_b.dot(d), ab = -along_a.dot(along_b);
    const double det = aa * bb - a.radius * b.radius * ab * ab;
    if (!(det > 0 && aa > 0)) return false;
    const double turn_a = std::clamp(-(bb * ga - b.radius * ab * gb) / det, -0.7, 0.7);
    const double turn_b = std::clamp(-(aa * gb - a.radius * ab * ga) / det, -0.7, 0.7);
    turn(a.c, a.s, turn_a);
    turn(b.c, b.s, turn_b);
    found = std::abs(turn_a) < newton_end && std::abs(turn_b) < newton_end;
  }
  w.a = a.point + a.radius * (a.c * a.u + a.s * a.v), w.b = b.point + b.radius * (b.c * b.u + b.s * b.v);
  const Vec3 across = (a.c * a.v - a.s * a.u).cross(b.c * b.v - b.s * b.u);
  w.n = unit_along(across.squaredNorm() > tolerance::clearly_crossing2 ? across : Vec3(w.b - w.a), w.n);
  return found;
}

}  // namespace

bool nearest_points(const Feature& fa, const Feature& fb, double rounding, NearestPoints& w) {
  if (fa.surface == Surface::corner) return corner_to_feature(fa.point, fb, rounding, w);
  if (fb.surface == Surface::corner) return w.exchanged([&] { return corner_to_feature(fb.point, fa, rounding, w); });
  if (fa.surface == Surface::circle)
    return fb.surface == Surface::circle ? circle_to_circle(fa, fb, w) : circle_to_line(fa, fb, rounding, w);
  if (fb.surface == Surface::circle) return w.exchanged([&] { return circle_to_line(fb, fa, rounding, w); });
  return straight_to_straight(fa, fb, rounding, w);
}

}  // namespace tandem
