// Clips rectangular faces, a pair a lane (vector kernel).
#include "manifold/rectangle_clip.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "manifold/rectangle_clip.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

#if !HWY_HAVE_SCALABLE

static_assert(RectanglePairRows::most % hn::MaxLanes(D()) == 0);

// The signs of a rectangle's corners along its two axes, counterclockwise.
constexpr bool on_right[4] = {true, false, false, true}, on_top[4] = {true, true, false, false};
HWY_INLINE V on_side(bool plus, V x) { return plus ? x : hn::Neg(x); }

/// The pairs of a vector; `append_box_manifold` from where its faces are known.
struct RectangleLanes {
  V centre[3], edge1[3], edge2[3], half_u, half_w, half1, half2, top, slant, slip_u, slip_w, distance, near, margin;
  bool tilted;  // for any lane
  RectanglePatchRows& found;
  std::size_t at;
  V touching;

  HWY_INLINE RectangleLanes(RectanglePatchRows& found_, std::size_t at_) : found(found_), at(at_) {}
  HWY_INLINE void read(const RectanglePairRows& pairs, const std::int64_t* columns, double margin_);
  HWY_INLINE M add_incident_corners(V (*corner)[3]);
  HWY_INLINE M add_reference_corners(M open);
  HWY_INLINE void add_crossings(const V (*corner)[3], M open);
  HWY_INLINE void add(int point, M valid, V u, V w, V height) {
    const D d;
    const V over = hn::Sub(top, height), rest = tilted ? hn::Div(over, slant) : over, most = hn::Neg(distance);
    V depth = hn::IfThenElse(hn::Lt(most, rest), most, rest);
    valid = hn::AndNot(hn::Lt(depth, hn::Sub(hn::Neg(margin), near)), valid);
    if (hn::AllFalse(d, valid)) return;
    const V least = hn::Neg(margin);
    depth = hn::IfThenElse(hn::Lt(depth, least), least, depth);
    const V half = hn::Mul(number(0.5), depth);
    const auto put = [&](V x, V reach, V slip, double* row) HWY_ATTR {
      hn::Store(hn::Sub(hn::Min(hn::Max(x, hn::Neg(reach)), reach), hn::Mul(half, slip)), d, row + at);
    };
    hn::Store(depth, d, found.depth[point] + at);
    put(u, half_u, slip_u, found.u[point]);
    put(w, half_w, slip_w, found.w[point]);
    touching = hn::Add(touching, hn::IfThenElseZero(valid, number(1u << point)));
  }
};

/// Gathers columns that are not consecutive.
HWY_INLINE void RectangleLanes::read(const RectanglePairRows& pairs, const std::int64_t* columns, double margin_) {
  const D d;
  const auto from = hn::LoadU(hn::RebindToSigned<D>(), columns);
  const auto column = [&](const double* row) HWY_ATTR { return hn::GatherIndex(d, row, from); };
  half_u = column(pairs.half_u);
  half_w = column(pairs.half_w);
  half1 = column(pairs.half1);
  half2 = column(pairs.half2);
  top = column(pairs.top);
  slant = column(pairs.slant);
  slip_u = column(pairs.slip_u);
  slip_w = column(pairs.slip_w);
  distance = column(pairs.distance);
  near = column(pairs.near);
  margin = number(margin_);
  touching = number(0);
  for (int k = 0; k < 3; ++k) {
    centre[k] = column(pairs.centre[k]);
    edge1[k] = column(pairs.edge1[k]);
    edge2[k] = column(pairs.edge2[k]);
  }
  tilted = !hn::AllTrue(d, hn::Eq(slant, number(1)));
}

/// Adds the incident corners over the reference face; true where some are not over it.
HWY_INLINE M RectangleLanes::add_incident_corners(V (*corner)[3]) {
  M all_inside = hn::Eq(near, near);
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k)
      corner[i][k] = hn::Add(centre[k], hn::Add(on_side(on_right[i], edge1[k]), on_side(on_top[i], edge2[k])));
    const M inside = hn::And(hn::Le(hn::Abs(corner[i][0]), hn::Add(half_u, near)),
                             hn::Le(hn::Abs(corner[i][1]), hn::Add(half_w, near)));
    all_inside = hn::And(all_inside, inside);
    add(i, inside, corner[i][0], corner[i][1], corner[i][2]);
  }
  return hn::Not(all_inside);
}

/// Adds the reference corners under the incident face, where `open`; true where some are not under it.
HWY_INLINE M RectangleLanes::add_reference_corners(M open) {
  const V one = number(1);
  const V det = hn::Sub(hn::Mul(edge1[0], edge2[1]), hn::Mul(edge1[1], edge2[0]));
  const V near1 = hn::Div(near, half1), near2 = hn::Div(near, half2);
  M all_covered = hn::Eq(one, one);
  for (int i = 0; i < 4; ++i) {
    const V to_u = on_side(on_right[i], half_u), to_w = on_side(on_top[i], half_w);
    const V u = hn::Sub(to_u, centre[0]), w = hn::Sub(to_w, centre[1]);
    const V p = hn::Div(hn::Sub(hn::Mul(u, edge2[1]), hn::Mul(w, edge2[0])), det);
    const V q = hn::Div(hn::Sub(hn::Mul(edge1[0], w), hn::Mul(edge1[1], u)), det);
    const M covered = hn::Not(hn::Or(hn::Gt(hn::Abs(p), hn::Add(one, near1)), hn::Gt(hn::Abs(q), hn::Add(one, near2))));
    all_covered = hn::And(all_covered, covered);
    const M at_corner = hn::And(hn::Ge(hn::Abs(p), hn::Sub(one, near1)), hn::Ge(hn::Abs(q), hn::Sub(one, near2)));
    const V height = hn::Add(centre[2], hn::Add(hn::Mul(p, edge1[2]), hn::Mul(q, edge2[2])));
    add(4 + i, hn::And(open, hn::AndNot(at_corner, covered)), to_u, to_w, height);
  }
  return hn::AndNot(all_covered, open);
}

/// Adds the crossings of incident and reference edges well between their ends, where `open`.
HWY_INLINE void RectangleLanes::add_crossings(const V (*corner)[3], M open) {
  const D d;
  for (int line = 0; line < 4; ++line) {
    const bool on_u = line < 2;
    const int across = on_u ? 0 : 1, along = on_u ? 1 : 0;
    const V place = on_side(line % 2 == 0, on_u ? half_u : half_w);
    const V reach = hn::Sub(on_u ? half_w : half_u, near);
    V before[4];
    M over[4], under[4];
    for (int i = 0; i < 4; ++i) {
      before[i] = hn::Sub(place, corner[i][across]);
      over[i] = hn::Gt(before[i], near);
      under[i] = hn::Lt(before[i], hn::Neg(near));
    }
    for (int i = 0; i < 4; ++i) {
      const int j = (i + 1) % 4;
      const M crossed = hn::And(open, hn::Or(hn::And(over[i], under[j]), hn::And(under[i], over[j])));
      if (hn::AllFalse(d, crossed)) continue;
      const V s = hn::Div(before[i], hn::Sub(before[i], before[j]));
      const auto between = [&](int k) HWY_ATTR {
        return hn::Add(corner[i][k], hn::Mul(s, hn::Sub(corner[j][k], corner[i][k])));
      };
      const V there = between(along);
      add(8 + 4 * line + i, hn::AndNot(hn::Gt(hn::Abs(there), reach), crossed), on_u ? place : there,
          on_u ? there : place, between(2));
    }
  }
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void clip_rectangles(const RectanglePairRows& pairs, const std::int64_t* columns, std::size_t count, double margin,
                     RectanglePatchRows& found) {
  const D d;
  for (std::size_t at = 0; at < count; at += hn::Lanes(d)) {
    RectangleLanes x(found, at);
    x.read(pairs, columns + at, margin);
    V corner[4][3];
    const M open = x.add_incident_corners(corner);
    if (!hn::AllFalse(d, open)) x.add_crossings(corner, x.add_reference_corners(open));
    hn::Store(x.touching, d, found.touching + at);
  }
}

#else

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void clip_rectangles(const RectanglePairRows&, const std::int64_t*, std::size_t count, double,
                     RectanglePatchRows& found) {
  std::fill_n(found.touching, count, 0.0);
}

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(clip_rectangles);

void clip_rectangles(const RectanglePairRows& pairs, const std::int64_t* columns, std::size_t count, double margin,
                     RectanglePatchRows& found) {
  HWY_DYNAMIC_DISPATCH(clip_rectangles)(pairs, columns, count, margin, found);
}
}  // namespace tandem
#endif
