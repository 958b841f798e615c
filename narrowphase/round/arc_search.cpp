// Minima of h on circles of directions, where one body's support has a kink.
#include "round/arc_search.h"

#include <utility>

#include "round/circle_floor.h"
#include "tolerances.h"

namespace tandem {
namespace {

/// Finds the minimum of h on intervals of a circle, where h is the support of `supporting` plus `add`. Between two
/// directions h is at least the support of the points that attain it at the ends; where that is less than the best
/// known value, the direction in which the two points' supports are equal is examined, too.
template <class Supporting>
class SpanSearch {
 public:
  /// `ends`: of an arc, the normals of the faces between which it lies; of a whole circle none.
  SpanSearch(Minima& m, const Circle& circle, double add, const Supporting& supporting, const CircleFloor& floor,
             std::span<const Vec3> ends = {})
      : m_(m),
        circle_(circle),
        lift_(circle.height),
        radius_(circle.radius),
        add_(add),
        supporting_(supporting),
        floor_(floor),
        ends_(ends) {}

  void search(const Span* spans, int count) {
    constexpr int most = 96, most_spans = 8;
    Span stack[most_spans + most];
    int height = count;
    std::copy(spans, spans + count, stack);
    for (int tried = 0; height > 0;) {
      const Span span = stack[--height];
      if (ruled_out(span)) continue;
      Vec3 out;
      double least = lowest(span, out);
      if (least >= m_.best.h - m_.rounding) continue;
      least = std::max(least, floor_.over(span) + add_);
      if (least >= m_.best.h - m_.rounding) continue;
      if (tried == most) {
        m_.gap = std::max(m_.gap, m_.best.h - least);
        continue;
      }
      if (holds_known(span, out)) continue;
      const Sample middle = evaluate(out);
      ++tried;
      if (m_.best.h < 0) return;
      if (direction(out).dot(middle.p) + add_ - least <= m_.rounding) continue;
      stack[height++] = {span.first, middle};
      stack[height++] = {middle, span.last};
    }
  }

 private:
  Vec3 direction(const Vec3& out) const { return lift_ * circle_.axis + radius_ * out; }

  Sample evaluate(const Vec3& out) {
    const Vec3 n = direction(out), p = supporting_(n);
    if (n.dot(p) + add_ < m_.best.h - m_.rounding) m_.try_from(n);
    return {out, p};
  }

  /// The minimum of the larger of the two end points' supports: where they are equal, or where one of them is least.
  double lowest(const Span& span, Vec3& out) const {
    const Vec3 &u = span.first.out, v = circle_.axis.cross(u), apart = span.first.p - span.last.p;
    double least = infinity;
    const auto consider = [&](const Vec3& at) {
      const Vec3 n = direction(at);
      const double value = std::max(n.dot(span.first.p), n.dot(span.last.p)) + add_;
      if (value < least) least = value, out = at;
    };
    // k + a cos + b sin = 0, solved for the tangent of half the angle.
    const double k = lift_ * apart.dot(circle_.axis), a = radius_ * apart.dot(u), b = radius_ * apart.dot(v);
    const double root = std::sqrt(std::max(0.0, b * b + a * a - k * k)) - b;
    if (root > 0) {
      const double t = std::max(0.0, k + a) / root;
      consider(((1 - t * t) * u + 2 * t * v) / (1 + t * t));
    }
    if (lift_ != 0 || add_ != 0)
      for (const Sample* end : {&span.first, &span.last}) {
        const Vec3 inward = end->p.dot(circle_.axis) * circle_.axis - end->p;
        const double length = inward.norm();
        if (!(length > m_.rounding && inward.dot(v) > 0 && circle_.axis.dot(inward.cross(span.last.out)) > 0)) continue;
        const Vec3 at = inward / length;
        consider((at - at.dot(circle_.axis) * circle_.axis).normalized());
      }
    return least;
  }

  /// True if the interval has no smaller value: one end's point may attain the support at the other end, too, and then
  /// between them, unless its support is least there.
  bool ruled_out(const Span& span) const {
    const auto reaches = [&](const Vec3& p, const Vec3& out, const Vec3& own) {
      const double limit = m_.best.h - m_.rounding - add_ - lift_ * circle_.axis.dot(p);
      return radius_ * out.dot(p) >= limit && (limit >= 0 || own.dot(p) >= 0);
    };
    return reaches(span.first.p, span.last.out, span.first.out) || reaches(span.last.p, span.first.out, span.last.out);
  }

  /// True if so short an interval contains a known minimum, or one is found from `out`: it has one, as a disc's support
  /// curves upwards on one stretch of a circle only. The normal of a face, where an arc ends, may be another one.
  bool holds_known(const Span& span, const Vec3& out) {
    constexpr double narrow = 0.1;
    const Vec3 along = span.last.out - span.first.out;
    const double width = along.squaredNorm();
    if (!(width < narrow * narrow)) return false;
    const auto holds = [&](const Vec3& n) {
      for (const Vec3& end : ends_)
        if ((n - end).squaredNorm() < tolerance::squared(tolerance::flush)) return false;
      const Vec3 to = n - direction(span.first.out);
      const double place = to.dot(along) / (radius_ * width);
      return std::abs(n.dot(circle_.axis) - lift_) < tolerance::on_circle && to.squaredNorm() < narrow * narrow &&
             place > -tolerance::arc_ends && place < 1 + tolerance::arc_ends;
    };
    for (int i = 0; i < m_.count; ++i)
      if (holds(m_.known[i])) return true;
    // A descent that starts beside a narrow minimum passes it: then only the points' supports count.
    return width > tolerance::squared(tolerance::narrow_arc) && holds(m_.try_from(direction(out)));
  }

  Minima& m_;
  const Circle& circle_;
  double lift_, radius_, add_;
  const Supporting& supporting_;
  const CircleFloor& floor_;
  std::span<const Vec3> ends_;
};

}  // namespace

void search_circle(Minima& m, int which, const Circle& circle, bool kink) {
  constexpr int start = 8;
  const RoundBody &body = m.pair.body[which], &other = m.pair.body[1 - which];
  const bool level = kink && body.is_level();
  const double ball = other.rolling_ball(circle), lift = circle.height, radius = circle.radius;
  const double add = (level ? body.level() : 0.0) + ball;
  const auto support = [&](const Vec3& n) -> Vec3 {
    return (level ? Vec3(body.middle() + other.support(n)) : m.pair.support(n)) - ball * n;
  };
  const auto opposite = [&](const Vec3& n, const Vec3& along) -> Vec3 {
    if (lift != 0 || !other.symmetric() || !body.symmetric()) return support(lift * circle.axis - radius * n);
    return 2 * (body.centre() + other.centre()) - along;
  };
  const auto at = [&](const Vec3& out, const Vec3& p) {
    const Vec3 n = lift * circle.axis + radius * out;
    if (n.dot(p) + add < m.best.h - m.rounding) m.try_from(n);
    return Sample{out, p};
  };
  const Vec3 x = any_perpendicular(circle.axis), y = circle.axis.cross(x);
  constexpr double half = 0.70710678118654752440;
  constexpr double turn[start / 2][2] = {{1, 0}, {half, half}, {0, 1}, {-half, half}};
  Sample samples[start];
  for (int i = 0; i < start / 2; ++i) {
    const Vec3 out = turn[i][0] * x + turn[i][1] * y;
    samples[i] = at(out, support(lift * circle.axis + radius * out));
    samples[i + start / 2] = at(-out, opposite(out, samples[i].p));
  }
  Span spans[start];
  for (int i = 0; i < start; ++i) spans[i] = {samples[i], samples[(i + 1) % start]};
  const CircleFloor floor = level ? CircleFloor(other, circle, body.middle()) : CircleFloor(circle);
  SpanSearch(m, circle, add, support, floor).search(spans, start);
}

void search_face_arcs(Minima& m, int which, const FaceReach& reach) {
  const RoundBody &body = m.pair.body[which], &other = m.pair.body[1 - which];
  // From face f to face g about their edge from v to w, of which f is on the left, in -B's mirror image on the right.
  // The edge is the axis: the cross product of the normals of a thin plate's faces, half a turn apart, is noise.
  const auto follow = [&](std::uint32_t v, std::uint32_t w, std::uint32_t f, std::uint32_t g) {
    if (!(m.best.h > 0) || reach.reaches(f, g, m.best.h - m.rounding)) return;
    if (which == 1) std::swap(v, w);
    const Circle circle = body.circle(static_cast<int>(v), static_cast<int>(w));
    const Vec3 corner = body.point(static_cast<int>(v), circle.axis);
    const auto support = [&](const Vec3& n) { return Vec3(corner + other.support(n)); };
    const auto sample = [&](std::uint32_t face) {
      const Vec3 n = face_normal(body, reach, face), out = (n - n.dot(circle.axis) * circle.axis).stableNormalized();
      return Sample{out, support(out)};
    };
    const Span span{sample(f), sample(g)};
    // The normals of faces that are nearly in one plane may be exchanged by rounding.
    if (!(circle.axis.dot(span.first.out.cross(span.last.out)) > 0)) return;
    for (const Sample* end : {&span.first, &span.last})
      if (end->out.dot(end->p) < m.best.h - m.rounding) m.try_from(end->out);
    const Vec3 ends[2] = {span.first.out, span.last.out};
    SpanSearch(m, circle, 0, support, CircleFloor(other, circle, corner), ends).search(&span, 1);
  };
  if (body.kind() == ShapeKind::box) {
    for (const FaceArc& arc : box_arcs) follow(arc.v[0], arc.v[1], arc.face[0], arc.face[1]);
  } else if (body.kind() == ShapeKind::triangle) {
    for (const std::uint32_t i : {0u, 1u, 2u}) {
      follow(i, (i + 1) % 3, 0, 2 + i);
      follow((i + 1) % 3, i, 1, 2 + i);
    }
  } else {
    const Hull& hull = body.hull();
    WorkMeter meter(m.pair.difference.limit, unchecked_edges(hull));
    for (std::uint32_t i = 0; i < hull.edges.size(); ++i) {
      meter.spend();
      const auto& [v, face] = hull.edges[i];
      if (hull.dimension == 3) {
        follow(v[0], v[1], face[0], face[1]);
      } else {
        follow(v[0], v[1], face[0], 2 + i);
        follow(v[1], v[0], face[1], 2 + i);
      }
    }
  }
}

}  // namespace tandem
