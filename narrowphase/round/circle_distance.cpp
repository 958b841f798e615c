// The distance of two circles.
#include "round/circle_distance.h"

#include "tolerances.h"

namespace tandem {
namespace {

struct Interval {
  double low, high;

  static Interval of(double p, double q) { return {std::min(p, q), std::max(p, q)}; }
  Interval operator+(const Interval& o) const { return {low + o.low, high + o.high}; }
  Interval operator*(double k) const { return of(k * low, k * high); }
  /// The product with an interval of numbers >= 0.
  Interval by(const Interval& k) const {
    return {low * (low < 0 ? k.high : k.low), high * (high > 0 ? k.high : k.low)};
  }
};

/// The square of an upper bound on the angle (radians) of an arc: a quarter circle is pi / sqrt(8) times its chord,
/// shorter arcs less.
double longest_arc2(const CircleDistance::Arc& arc) {
  constexpr double most = 1.234;  // the square of that ratio, rounded up
  return most * arc.chord2();
}

}  // namespace

CircleDistance::CircleDistance(const RoundBody& a, const RoundBody& b)
    : a_(&a), b_(&b), first_(a.radius() >= b.radius()), lift_{a.circle_lift(), b.circle_lift()} {
  if (!first_) std::swap(lift_[0], lift_[1]);
  const RoundBody &large = first_ ? a : b, &small = first_ ? b : a;
  large_ = large.radius(), small_ = small.radius();
  const Vec3 axis = large.axis(), other = small.axis(), cross = axis.cross(other);
  // For axes parallel to rounding any direction is perpendicular to both.
  Vec3 across = cross.norm() > 4 * epsilon ? cross.normalized() : any_perpendicular(axis);
  across = (across - across.dot(axis) * axis).normalized();
  frame_ << across, axis.cross(across), axis;
  lean_ = other.dot(frame_.col(1)), upright_ = other.dot(axis);
}

bool CircleDistance::take(int piece_a, int piece_b, double below, double rounding) {
  centre_ = frame_.transpose() * (a_->circle_centre(piece_a) + b_->circle_centre(piece_b));
  out_ = centre_[1] * upright_ - centre_[2] * lean_;
  const double sine = std::abs(lean_), farthest = std::abs(centre_[2]) + small_ * sine;
  const double beside = std::sqrt(centre_[0] * centre_[0] + out_ * out_);
  off_bend_ = 2 * small_ * (beside + sine * (farthest + small_ * sine));
  facing_[0] = a_->facing(piece_a), facing_[1] = b_->facing(piece_b);
  if (!first_) std::swap(facing_[0], facing_[1]);
  const double over[2] = {centre_[2], centre_[1] * lean_ + centre_[2] * upright_};
  const double sway[2] = {small_ * sine, large_ * sine};
  for (int k = 0; k < 2; ++k) {
    if (facing_[k] * over[k] + sway[k] <= rounding - lift_[k] * below) return false;
    if (std::abs(over[k]) - sway[k] > below) return false;
  }
  return true;
}

CircleDistance::Sample CircleDistance::at(double cosine, double sine) const {
  Sample s;
  s.cosine = cosine, s.sine = sine;
  s.u = centre_[0] + small_ * cosine;
  s.w = centre_[1] + small_ * sine * upright_;
  s.x = centre_[2] - small_ * sine * lean_;
  // On the larger circle's axis all of its points are equally near.
  s.off = std::max(std::sqrt(s.u * s.u + s.w * s.w), epsilon * large_);
  s.squared = s.x * s.x + (s.off - large_) * (s.off - large_);
  return s;
}

CircleDistance::Sample CircleDistance::between(const Arc& arc, double weight) const {
  const double c = (1 - weight) * arc.first.cosine + weight * arc.last.cosine;
  const double s = (1 - weight) * arc.first.sine + weight * arc.last.sine;
  const double length = std::sqrt(c * c + s * s);
  return at(c / length, s / length);
}

bool CircleDistance::supports(const Sample& s, double rounding) const {
  const Vec3 p = sum(s);
  const double length = s.length();
  return large_ - s.off > rounding && facing_[0] * s.x > rounding - lift_[0] * length &&
         facing_[1] * (lean_ * p[1] + upright_ * s.x) > rounding - lift_[1] * length &&
         s.cosine * p[0] + s.sine * (upright_ * p[1] - lean_ * s.x) > rounding;
}

double CircleDistance::turn(const Sample& s) const {
  const Vec3 p = sum(s);
  return s.cosine * (upright_ * p[1] - lean_ * s.x) - s.sine * p[0];
}

double CircleDistance::least_squared(const Arc& arc) const {
  const auto& [first, last] = arc;
  const auto under = [&](const Sample& at, const Sample& to) {
    const double m = (at.off - large_) / at.off;
    const double g[2] = {2 * small_ * m * centre_[0], 2 * small_ * (m * out_ - (1 - m) * at.x * lean_)};
    // Opposite to the gradient, if that is on the arc; else at an end.
    if (g[0] * arc.first.sine > g[1] * arc.first.cosine && g[1] * arc.last.cosine > g[0] * arc.last.sine)
      return at.squared - std::sqrt(g[0] * g[0] + g[1] * g[1]) - (g[0] * at.cosine + g[1] * at.sine);
    return at.squared + std::min(0.0, g[0] * (to.cosine - at.cosine) + g[1] * (to.sine - at.sine));
  };
  return std::max(under(first, last), under(last, first));
}

int CircleDistance::arcs(double below, double rounding, Arc* all) const {
  // The interval of sines where the larger circle supports the sum.
  double low = -1, high = 1;
  const double rise = -facing_[0] * small_ * lean_, start = facing_[0] * centre_[2];
  if (std::abs(rise) > rounding) {
    const Interval sine = Interval::of((rounding - lift_[0] * below - start) / rise, (below - start) / rise);
    low = std::max(low, sine.low), high = std::min(high, sine.high);
  }
  int count = 0;
  const auto add = [&](double from, double to) {
    if (!(from < to)) return;
    const double c = std::sqrt(1 - from * from), d = std::sqrt(1 - to * to);
    all[count++] = {at(c, from), at(d, to)};
    all[count++] = {at(-d, to), at(-c, from)};
  };
  add(low, std::min(high, 0.0));
  add(std::max(low, 0.0), high);
  return count;
}

bool CircleDistance::may_have_minimum(const Arc& arc, double below, double rounding) const {
  const auto& [first, last] = arc;
  // A function differs from the interval of its end values by at most its second derivative times an eighth of the
  // square of the angle.
  const double square[2] = {first.off * first.off, last.off * last.off}, bulge = off_bend_ / 8 * longest_arc2(arc);
  const double least = std::max(std::sqrt(std::max(0.0, std::min(square[0], square[1]) - bulge)), large_ - below);
  const double most = std::min(std::sqrt(std::max(square[0], square[1]) + bulge), large_);
  if (large_ - least <= rounding || most < large_ - below) return false;

  // The sum is -m u, -m w, x.
  const Interval u = Interval::of(first.u, last.u), w = Interval::of(first.w, last.w),
                 x = Interval::of(first.x, last.x);
  const Interval m{large_ / most - 1, std::max(0.0, large_ / std::max(least, epsilon * large_) - 1)};
  const double highest = std::max(-x.low, x.high), aside = large_ - least;
  const double longest = std::min(below, std::sqrt(highest * highest + aside * aside));
  if ((x * facing_[0]).high <= rounding - lift_[0] * longest) return false;
  const Interval along = (w.by(m) * -lean_ + x * upright_) * facing_[1];
  if (along.high <= rounding - lift_[1] * longest) return false;
  const double sign_c = first.cosine + last.cosine < 0 ? -1 : 1, sign_s = first.sine + last.sine < 0 ? -1 : 1;
  const Interval c = Interval::of(std::abs(first.cosine), std::abs(last.cosine));
  const Interval s = Interval::of(std::abs(first.sine), std::abs(last.sine));
  const Interval in = ((u * sign_c).by(c) + (w * (upright_ * sign_s)).by(s)).by(m) + (x * (lean_ * sign_s)).by(s);
  if (in.low >= -rounding) return false;
  // Minus the sum along the tangent, in two forms. Far from the axis the second interval is wide, near it the first.
  const Interval ahead =
      m.high < 1
          ? ((m * out_ + x.by({1 + m.low, 1 + m.high}) * lean_) * sign_c).by(c) + (m * (-centre_[0] * sign_s)).by(s)
          : ((w * (upright_ * sign_c)).by(c) + (u * -sign_s).by(s)).by(m) + (x * (lean_ * sign_c)).by(c);
  return ahead.low <= rounding && ahead.high >= -rounding;
}

double CircleDistance::bend(const Sample& s) const {
  const Vec3 p = sum(s);
  const double around = (s.sine * s.w + s.cosine * upright_ * s.u) / s.off;
  return small_ * (1 - large_ / s.off * around * around) - s.cosine * p[0] - s.sine * (upright_ * p[1] - lean_ * s.x);
}

CircleDistance::Minima CircleDistance::minima(const Arc& arc) const {
  const auto& [first, last] = arc;
  const double half = 0.5 * std::sqrt(longest_arc2(arc));
  const double near = 0.5 * (first.off + last.off) - small_ * half;
  if (!(near > 0)) return Minima::unknown;
  // Bounds on the derivatives by the angle: of the sum, and of its component along directions that rotate with the
  // angle.
  const double k = large_ / near, change = small_ * std::max(1.0, k - 1);
  const double turned = change + std::sqrt(std::max(first.squared, last.squared)) + change * half;
  // A function with a derivative of at most v is within v times half of the angle of the mean of its ends. In bend()
  // the inverse of the distance from the axis changes by at most small_ / near relatively, the cosine to the direction
  // around it by 1 + small_ / near.
  const double rate = small_ * k * (3 * small_ / near + 2) + turned;
  const double mean = 0.5 * (bend(first) + bend(last)), spread = rate * half;
  if (mean + spread < 0) return Minima::none;
  if (!(mean - spread > 0)) return Minima::unknown;
  return turn(first) <= 0 && turn(last) >= 0 ? Minima::one : Minima::none;
}

CircleDistance::Sample CircleDistance::minimum(Arc arc) const {
  constexpr int most = 60;
  double low = turn(arc.first), high = turn(arc.last);
  for (int i = 0; i < most && low < 0 && high > 0; ++i) {
    const Sample s = between(arc, low / (low - high));
    // They differ only in the last digits.
    if ((s.cosine == arc.first.cosine && s.sine == arc.first.sine) ||
        (s.cosine == arc.last.cosine && s.sine == arc.last.sine))
      return s;
    const double at = turn(s);
    if (at < 0) {
      arc.first = s, low = at, high *= 0.5;
    } else {
      arc.last = s, high = at, low *= 0.5;
    }
  }
  return low >= 0 ? arc.first : arc.last;
}

}  // namespace tandem
