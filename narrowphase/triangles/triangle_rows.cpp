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

static_assert(TriangleRows::most % hn::MaxLanes(D()) == 0);

HWY_INLINE M negative(V x) { return hn::Lt(x, hn::Zero(D())); }
HWY_INLINE M differ_in_sign(V x, V y) { return hn::Xor(negative(x), negative(y)); }

// How the corners of `other` lie to the plane of t: the sign of a volume.
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

// The corner that is alone on its side comes first, the others follow in the sense in which the other triangle's, which
// lie to `others` of this one's plane, has its own on the positive side.
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

}  // namespace

// As TriangleTest does, with its bounds. NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
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

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(compare_triangles);

FrameNumbers::FrameNumbers(const TriangleTest& test) {
  for (int k = 0; k < 9; ++k) pose[k] = test.map()(k % 3, k / 3);
  for (int k = 0; k < 3; ++k) pose[9 + k] = test.shift()[k];
}

TriangleVerdicts compare_triangles(const TriangleRows& pairs, std::size_t count, const TriangleTest& test) {
  return HWY_DYNAMIC_DISPATCH(compare_triangles)(pairs, count, FrameNumbers(test).pose, test.of_places());
}
}  // namespace tandem
#endif
