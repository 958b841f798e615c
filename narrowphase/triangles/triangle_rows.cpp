// Triangles in lanes: intersection tests, crossing segments, farthest points (vector kernels).
#include "triangles/triangle_rows.h"

#include <limits>

#include "tolerances.h"
#include "triangles/predicates.h"

#include "lanes/lanes_of_256_bits.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "triangles/triangle_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "triangles/triangle_lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

namespace {

static_assert(TriangleRows::most % hn::MaxLanes(D()) == 0 && CrossingRows::most % hn::MaxLanes(D()) == 0 &&
              DirectionRows::most % hn::MaxLanes(D()) == 0);

HWY_INLINE M negative(V x) { return hn::Lt(x, hn::Zero(D())); }
HWY_INLINE M differ_in_sign(V x, V y) { return hn::Xor(negative(x), negative(y)); }

// The sides of t's plane on which the corners of `other` lie: signs of volumes.
HWY_INLINE void sides(const V (&t)[3][3], const V (&other)[3][3], V* side) {
  V n[3];
  area_vector(t, n);
  for (int c = 0; c < 3; ++c) {
    V offset[3];
    subtract(other[c], t[0], offset);
    side[c] = dot(n, offset);
  }
}

HWY_INLINE V det(const V* a, const V* b, const V* c, const V* d) {
  V u[3], v[3], w[3], n[3];
  subtract(a, d, u);
  subtract(b, d, v);
  subtract(c, d, w);
  cross(v, w, n);
  return dot(u, n);
}

// Puts the corner that is alone on its side first; the others follow in the orientation that has the other triangle's
// alone corner on the positive side, where `others` are that triangle's sides of this plane.
HWY_INLINE void put_alone_first(const V (&t)[3][3], const V* side, const V* others, V (&out)[3][3]) {
  const M not_first = differ_in_sign(side[1], side[2]), third = differ_in_sign(side[0], side[2]);
  const M swapped = hn::Xor(differ_in_sign(others[0], others[1]), negative(others[2]));
  for (int k = 0; k < 3; ++k) {
    const auto pick = [&](int first, int second, int last) HWY_ATTR {
      return hn::IfThenElse(not_first, hn::IfThenElse(third, t[last][k], t[second][k]), t[first][k]);
    };
    const V second = pick(1, 2, 0), last = pick(2, 0, 1);
    out[0][k] = pick(0, 1, 2);
    out[1][k] = hn::IfThenElse(swapped, last, second);
    out[2][k] = hn::IfThenElse(swapped, second, last);
  }
}

// The point where an edge of a triangle crosses the other's plane.
struct EdgePoint {
  V point[3], part, edge, along;
  M from_inside;
};

HWY_INLINE void choose(M first, const EdgePoint& x, const EdgePoint& y, EdgePoint& out) {
  for (int k = 0; k < 3; ++k) out.point[k] = hn::IfThenElse(first, x.point[k], y.point[k]);
  out.part = hn::IfThenElse(first, x.part, y.part);
  out.edge = hn::IfThenElse(first, x.edge, y.edge);
  out.along = hn::IfThenElse(first, x.along, y.along);
  out.from_inside = hn::Or(hn::And(first, x.from_inside), hn::AndNot(first, y.from_inside));
}

// The two edges of a triangle that cross the other's plane, ordered along the common line of both planes.
HWY_INLINE M cut(const V (&p)[3][3], const V* normal, const V* on_plane, const V* line, double first_edge,
                 EdgePoint (&out)[2]) {
  V height[3];
  M above[3];
  for (int c = 0; c < 3; ++c) {
    V offset[3];
    subtract(p[c], on_plane, offset);
    height[c] = dot(normal, offset);
    above[c] = hn::Ge(height[c], hn::Zero(D()));
  }
  EdgePoint at[2];
  const auto take = [&](M is_next, int edge, int next_edge, EdgePoint& e) HWY_ATTR {
    const auto pick = [&](V x, V y) HWY_ATTR { return hn::IfThenElse(is_next, y, x); };
    const int end = (edge + 1) % 3, next_end = (next_edge + 1) % 3;
    const V from = pick(height[edge], height[next_edge]), to = pick(height[end], height[next_end]);
    e.part = hn::Div(from, hn::Sub(from, to));
    for (int k = 0; k < 3; ++k) {
      const V start = pick(p[edge][k], p[next_edge][k]);
      e.point[k] = hn::Add(start, hn::Mul(e.part, hn::Sub(pick(p[end][k], p[next_end][k]), start)));
    }
    e.edge = pick(number(first_edge + edge), number(first_edge + next_edge));
    e.along = dot(line, e.point);
    e.from_inside = hn::Lt(from, hn::Zero(D()));
  };
  const M skips_0 = hn::Not(hn::Xor(above[0], above[1])), crosses_1 = hn::Xor(above[1], above[2]);
  take(skips_0, 0, 1, at[0]);
  take(hn::Or(skips_0, hn::Not(crosses_1)), 1, 2, at[1]);
  const M swapped = hn::Lt(at[1].along, at[0].along);
  choose(swapped, at[1], at[0], out[0]);
  choose(swapped, at[0], at[1], out[1]);
  return hn::Or(hn::Not(skips_0), crosses_1);
}

}  // namespace

// As TriangleTest, with its bounds. NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
TriangleVerdicts compare_triangles(const TriangleRows& pairs, std::size_t count, const double* pose, double of_places) {
  const D d;
  TriangleVerdicts verdicts{0, 0};
  for (std::size_t at = 0; at < count; at += hn::Lanes(d)) {
    V p[3][3], q[3][3], span = hn::Zero(d);
    load_triangles(pairs, at, pose, p, q);
    for (int k = 0; k < 3; ++k) {
      const V low = hn::Min(hn::Min(hn::Min(p[0][k], p[1][k]), p[2][k]), hn::Min(hn::Min(q[0][k], q[1][k]), q[2][k]));
      const V high = hn::Max(hn::Max(hn::Max(p[0][k], p[1][k]), p[2][k]), hn::Max(hn::Max(q[0][k], q[1][k]), q[2][k]));
      span = hn::Max(span, hn::Sub(high, low));
    }
    const V bound = hn::Add(hn::Mul(hn::Mul(span, span),
                                    hn::Add(number(of_places), hn::Mul(number(tolerance::determinant_rounding), span))),
                            number(std::numeric_limits<double>::min()));
    const V below = hn::Neg(bound);
    V side_a[3], side_b[3];
    sides(q, p, side_a);
    sides(p, q, side_b);
    M all_sure = hn::FirstN(d, count - at), apart = hn::Lt(bound, hn::Zero(d));
    const M asked = all_sure;
    for (const V* side : {side_a, side_b}) {
      const V lowest = hn::Min(hn::Min(side[0], side[1]), side[2]),
              highest = hn::Max(hn::Max(side[0], side[1]), side[2]);
      apart = hn::Or(apart, hn::Or(hn::Gt(lowest, bound), hn::Lt(highest, below)));
      for (int c = 0; c < 3; ++c) all_sure = hn::And(all_sure, hn::Gt(hn::Abs(side[c]), bound));
    }
    V r[3][3], s[3][3];
    put_alone_first(p, side_a, side_b, r);
    put_alone_first(q, side_b, side_a, s);
    const V first = det(r[0], r[1], s[0], s[1]), second = det(r[0], r[2], s[2], s[0]);
    const M crossing = hn::And(all_sure, hn::And(hn::Gt(first, bound), hn::Gt(second, bound)));
    const M missing = hn::And(all_sure, hn::Or(hn::Lt(first, below), hn::Lt(second, below)));
    const M meet = hn::AndNot(apart, crossing);
    const M unknown = hn::AndNot(hn::Or(apart, hn::Or(crossing, missing)), asked);
    verdicts.meet |= bits_of(meet) << at;
    verdicts.unknown |= bits_of(unknown) << at;
  }
  return verdicts;
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void cross_triangles(const TriangleRows& pairs, std::size_t count, const double* pose, CrossingRows& out) {
  const D d;
  out.crosses = out.end[0].from_inside = out.end[1].from_inside = 0;
  for (std::size_t at = 0; at < count; at += hn::Lanes(d)) {
    V p[3][3], q[3][3], normal_a[3], normal_b[3], line[3];
    load_triangles(pairs, at, pose, p, q);
    area_vector(p, normal_a);
    area_vector(q, normal_b);
    cross(normal_a, normal_b, line);
    EdgePoint a[2], b[2], end[2];
    const M both = hn::And(cut(p, normal_b, q[0], line, 0, a), cut(q, normal_a, p[0], line, 3, b));
    choose(hn::Ge(a[0].along, b[0].along), a[0], b[0], end[0]);
    choose(hn::Le(a[1].along, b[1].along), a[1], b[1], end[1]);
    out.crosses |= bits_of(hn::And(both, hn::FirstN(d, count - at))) << at;
    for (int e = 0; e < 2; ++e) {
      store(end[e].point, at, out.end[e].point);
      hn::Store(end[e].part, d, out.end[e].part + at);
      hn::Store(end[e].edge, d, out.end[e].edge + at);
      out.end[e].from_inside |= bits_of(end[e].from_inside) << at;
    }
  }
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void find_farthest(DirectionRows* rows, std::size_t used, const double* points, std::size_t stride, std::size_t first,
                   std::size_t last) {
  const D d;
  for (std::size_t at = 0; at < used; at += hn::Lanes(d)) {
    V direction[3];
    load(rows->direction, at, direction);
    const auto along = [&](const double* p) HWY_ATTR {
      const V point[3] = {number(p[0]), number(p[1]), number(p[2])};
      return dot(direction, point);
    };
    V best = first == 0 ? hn::Zero(d) : hn::Load(d, rows->best + at);
    V most = first == 0 ? along(points) : hn::Load(d, rows->reach + at);
    for (std::size_t i = std::max<std::size_t>(first, 1); i < last; ++i) {
      const V here = along(points + i * stride);
      best = hn::IfThenElse(hn::Gt(here, most), number(static_cast<double>(i)), best);
      most = hn::Max(most, here);
    }
    hn::Store(best, d, rows->best + at);
    hn::Store(most, d, rows->reach + at);
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(compare_triangles);
HWY_EXPORT(cross_triangles);
HWY_EXPORT(find_farthest);

FrameNumbers::FrameNumbers(const TriangleTest& test) {
  for (int k = 0; k < 9; ++k) pose[k] = test.map()(k % 3, k / 3);
  for (int k = 0; k < 3; ++k) pose[9 + k] = test.shift()[k];
}

TriangleVerdicts compare_triangles(const TriangleRows& pairs, std::size_t count, const TriangleTest& test) {
  return HWY_DYNAMIC_DISPATCH(compare_triangles)(pairs, count, FrameNumbers(test).pose, test.of_places());
}

void cross_triangles(const TriangleRows& pairs, std::size_t count, const TriangleTest& frame, CrossingRows& out) {
  HWY_DYNAMIC_DISPATCH(cross_triangles)(pairs, count, FrameNumbers(frame).pose, out);
}

void find_farthest(DirectionRows& rows, std::size_t used, const double* points, std::size_t stride, std::size_t first,
                   std::size_t last) {
  HWY_DYNAMIC_DISPATCH(find_farthest)(&rows, used, points, stride, first, last);
}
}  // namespace tandem
#endif
