// The distance of two circles, to which the depth of two discs reduces.
#pragma once
#include "shapes/round_body.h"

namespace tandem {

/// A circle of one body and a circle of the other, summands of A - B. Where h has a minimum and is smooth, both bodies
/// are supported on circles (with one circle or none h curves downwards along some tangent), and h n is the sum of a
/// point of each that no neighbours bring nearer the origin: a minimum of the distance of two circles, one of them
/// mirrored. For a point of the smaller circle the nearest of the larger is known, so that the shortest sum is a
/// function of one angle. Its square is a convex function of the angle's cosine and sine (with E the squared distance
/// from the larger circle's centre and x the height over its plane, both linear in them, E + R^2 - 2 R sqrt(E - x^2)),
/// and lies over its tangent planes. Minima nearer than rounding to where another piece takes over, a disc, a side or
/// an apex, are left to the search there: h is the same to the square of that.
class CircleDistance {
 public:
  CircleDistance(const RoundBody& a, const RoundBody& b);

  /// Sets the two circles; false if no sum shorter than `below` has both bodies supported along it.
  bool take(int piece_a, int piece_b, double below, double rounding);

  /// A point of the smaller circle by its angle, in the frame.
  struct Sample {
    double cosine, sine;
    double u, w, x;  ///< coordinates across the larger circle's axis, and above its plane
    double off;      ///< distance from that axis
    double squared;  ///< squared length of the shortest sum
    double length() const { return std::sqrt(squared); }
  };
  Sample at(double cosine, double sine) const;
  /// The unit vector along the sum.
  Vec3 direction(const Sample& s) const { return frame_ * sum(s) / s.length(); }
  /// True if both bodies are supported on these circles along the sum, beyond rounding.
  bool supports(const Sample& s, double rounding) const;

  /// An arc from one point to another, counterclockwise, within a quadrant, where cosine and sine are monotone.
  struct Arc {
    Sample first, last;

    double chord2() const {
      const double c = last.cosine - first.cosine, s = last.sine - first.sine;
      return c * c + s * s;
    }
  };
  /// Sets all arcs that may have a minimum: a sum shorter than `below` along which both bodies are supported. Returns
  /// how many.
  static constexpr int most_arcs = 4;
  int arcs(double below, double rounding, Arc* all) const;
  /// True if an arc may have a minimum, by interval arithmetic.
  bool may_have_minimum(const Arc& arc, double below, double rounding) const;
  /// A lower bound on the squared length of an arc's sums.
  double least_squared(const Arc& arc) const;
  /// The number of minima, supported or not.
  enum class Minima { none, one, unknown };
  Minima minima(const Arc& arc) const;
  /// The only minimum of an arc. By regula falsi with halved weights (Dowell and Jarratt, The "Illinois" algorithm,
  /// 1971).
  Sample minimum(Arc arc) const;
  Sample middle(const Arc& arc) const { return between(arc, 0.5); }

 private:
  Vec3 sum(const Sample& s) const {
    const double m = (s.off - large_) / s.off;
    return {m * s.u, m * s.w, s.x};
  }
  /// The derivative of turn() by the angle.
  double bend(const Sample& s) const;
  /// Half of the derivative of the squared length by the angle, over the smaller radius.
  double turn(const Sample& s) const;
  Sample between(const Arc& arc, double weight) const;

  const RoundBody *a_, *b_;
  bool first_;            ///< a's circle is the larger
  /// Columns: perpendicular to both axes, perpendicular to that and the larger's axis, that axis.
  Mat3 frame_;
  double large_, small_;  ///< radii
  double lift_[2];        ///< of the larger and the smaller circle: circle_lift
  double facing_[2] = {1, 1};
  double lean_, upright_;       ///< components of the smaller circle's axis: 0, lean_, upright_
  Vec3 centre_ = Vec3::Zero();  ///< the sum of both centres
  double out_ = 0;              ///< its component along the smaller circle's second axis; the first axis is the frame's
  double off_bend_ = 0;         ///< upper bound on the second derivative of the squared Sample::off by the angle
};

}  // namespace tandem
