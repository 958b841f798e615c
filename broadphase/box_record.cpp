#include "box_record.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "box_record.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::size_t copy_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray* within,
                       BoxRecord* records, std::uint32_t* outside) {
  const hn::ScalableTag<float> df;
  const hn::RebindToUnsigned<decltype(df)> du;
  const hn::CappedTag<float, 4> quad;
  const std::size_t lanes = hn::Lanes(df);
  HWY_ALIGN float lo[4 * hn::MaxLanes(df)], hi[4 * hn::MaxLanes(df)];

  std::size_t count = 0;
  for (std::size_t i = begin; i < end; i += lanes) {
    const auto lo0 = hn::LoadU(df, boxes.lo(0) + i), hi0 = hn::LoadU(df, boxes.hi(0) + i);
    const auto lo1 = hn::LoadU(df, boxes.lo(1) + i), hi1 = hn::LoadU(df, boxes.hi(1) + i);
    const auto lo2 = hn::LoadU(df, boxes.lo(2) + i), hi2 = hn::LoadU(df, boxes.hi(2) + i);
    hn::StoreInterleaved4(lo0, lo1, lo2, hn::Zero(df), df, lo);
    hn::StoreInterleaved4(hi0, hi1, hi2, hn::Zero(df), df, hi);
    const std::size_t here = end - i < lanes ? end - i : lanes;
    for (std::size_t k = 0; k < here; ++k) {
      for (std::size_t axis = 0; axis < 4; axis += hn::Lanes(quad)) {
        hn::Store(hn::Load(quad, lo + 4 * k + axis), quad, records[i + k].lo + axis);
        hn::Store(hn::Load(quad, hi + 4 * k + axis), quad, records[i + k].hi + axis);
      }
    }
    if (within == nullptr) continue;
    const auto x =
        hn::And(hn::Le(hn::LoadU(df, within->lo(0) + i), lo0), hn::Le(hi0, hn::LoadU(df, within->hi(0) + i)));
    const auto y =
        hn::And(hn::Le(hn::LoadU(df, within->lo(1) + i), lo1), hn::Le(hi1, hn::LoadU(df, within->hi(1) + i)));
    const auto z =
        hn::And(hn::Le(hn::LoadU(df, within->lo(2) + i), lo2), hn::Le(hi2, hn::LoadU(df, within->hi(2) + i)));
    const auto inside = hn::And(x, hn::And(y, z));
    if (hn::AllTrue(df, inside)) continue;
    auto out = hn::Not(inside);
    if (here < lanes) out = hn::And(out, hn::FirstN(df, here));
    const auto index = hn::Iota(du, static_cast<std::uint32_t>(i));
    count += hn::CompressStore(index, hn::RebindMask(du, out), du, outside + count);
  }
  return count;
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
std::size_t overlapping(const BoxRecord* records, const Pair* pairs, std::size_t count, Pair* out) {
  const hn::CappedTag<float, 4> d;
  constexpr std::size_t ahead = 24;  // pairs, some 50 ns
  std::size_t hits = 0;
  const auto test = [&](std::size_t i) HWY_ATTR {
    const Pair pair = pairs[i];
    const BoxRecord &a = records[pair.a], &b = records[pair.b];
    bool hit = true;
    for (std::size_t axis = 0; axis < 4; axis += hn::Lanes(d)) {
      const auto below = hn::Le(hn::Load(d, a.lo + axis), hn::Load(d, b.hi + axis));
      const auto above = hn::Le(hn::Load(d, b.lo + axis), hn::Load(d, a.hi + axis));
      hit = hit & hn::AllTrue(d, hn::And(below, above));
    }
    out[hits] = pair;  // without a branch: which pairs overlap is not to be foreseen
    hits += hit ? 1 : 0;
  };
  std::size_t i = 0;
  for (; i + ahead < count; ++i) {
    hwy::Prefetch(records + pairs[i + ahead].a);
    hwy::Prefetch(records + pairs[i + ahead].b);
    test(i);
  }
  for (; i < count; ++i) test(i);
  return hits;
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
void enlarge_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxRecord* past, float steps,
                   float usual, BoxArray& larger) {
  const hn::ScalableTag<float> df;
  using V = hn::Vec<decltype(df)>;
  const hn::CappedTag<float, 4> quad;
  const std::size_t lanes = hn::Lanes(df);
  HWY_ALIGN float past_lo[4 * hn::MaxLanes(df)] = {}, past_hi[4 * hn::MaxLanes(df)] = {};
  constexpr float largest = std::numeric_limits<float>::max();
  const auto zero = hn::Zero(df), half = hn::Set(df, 0.5f), most = hn::Set(df, largest);
  const auto least_sweep = hn::Set(df, usual * steps), usual_motion = hn::Set(df, usual), ahead = hn::Set(df, steps);

  // Past the end may be another block's boxes: the last vector is stored by parts.
  HWY_ALIGN float part[hn::MaxLanes(df)];
  for (std::size_t i = begin; i < end; i += lanes) {
    const std::size_t here = end - i < lanes ? end - i : lanes;
    for (std::size_t k = 0; k < here; ++k) {
      for (std::size_t axis = 0; axis < 4; axis += hn::Lanes(quad)) {
        hn::Store(hn::Load(quad, past[i + k].lo + axis), quad, past_lo + 4 * k + axis);
        hn::Store(hn::Load(quad, past[i + k].hi + axis), quad, past_hi + 4 * k + axis);
      }
    }
    V p0, p1, p2, q0, q1, q2, unused;
    hn::LoadInterleaved4(df, past_lo, p0, p1, p2, unused);
    hn::LoadInterleaved4(df, past_hi, q0, q1, q2, unused);
    const auto lo0 = hn::LoadU(df, boxes.lo(0) + i), hi0 = hn::LoadU(df, boxes.hi(0) + i);
    const auto lo1 = hn::LoadU(df, boxes.lo(1) + i), hi1 = hn::LoadU(df, boxes.hi(1) + i);
    const auto lo2 = hn::LoadU(df, boxes.lo(2) + i), hi2 = hn::LoadU(df, boxes.hi(2) + i);

    const auto size = hn::Max(hn::Sub(hi0, lo0), hn::Max(hn::Sub(hi1, lo1), hn::Sub(hi2, lo2)));
    const auto farther = [&](V a, V b, V c, V d)
                             HWY_ATTR { return hn::Max(hn::Abs(hn::Sub(a, b)), hn::Abs(hn::Sub(c, d))); };
    const auto motion =
        hn::Max(farther(lo0, p0, hi0, q0), hn::Max(farther(lo1, p1, hi1, q1), farther(lo2, p2, hi2, q2)));
    const auto goes_on = hn::Le(motion, hn::Max(hn::Mul(half, size), usual_motion));
    const auto bounded = hn::And(hn::Lt(size, most), hn::Le(lo0, hi0));
    const auto sweep = hn::Max(size, least_sweep);

    const auto enlarge = [&](V lo, V hi, V p, V q, float* to_lo, float* to_hi) HWY_ATTR {
      const auto lo_step = hn::IfThenElseZero(goes_on, hn::Sub(lo, p));
      const auto hi_step = hn::IfThenElseZero(goes_on, hn::Sub(hi, q));
      // Far from the origin rounding alone moves a box by its last bit.
      const auto last_bit =
          hn::Mul(hn::Set(df, std::numeric_limits<float>::epsilon()), hn::Max(hn::Abs(lo), hn::Abs(hi)));
      const auto grow = hn::Add(hn::Add(hn::Mul(hn::Set(df, 0.02f), hn::Sub(hi, lo)),
                                        hn::Mul(hn::Set(df, 0.25f), hn::Max(hn::Abs(lo_step), hn::Abs(hi_step)))),
                                last_bit);
      const auto down = hn::Min(hn::Max(hn::Mul(lo_step, ahead), hn::Neg(sweep)), zero);
      const auto up = hn::Max(hn::Min(hn::Mul(hi_step, ahead), sweep), zero);
      const auto new_lo = hn::IfThenElse(bounded, hn::Max(hn::Sub(hn::Add(lo, down), grow), hn::Neg(most)), lo);
      const auto new_hi = hn::IfThenElse(bounded, hn::Min(hn::Add(hn::Add(hi, up), grow), most), hi);
      if (here == lanes) {
        hn::StoreU(new_lo, df, to_lo + i);
        hn::StoreU(new_hi, df, to_hi + i);
      } else {
        hn::Store(new_lo, df, part);
        std::copy(part, part + here, to_lo + i);
        hn::Store(new_hi, df, part);
        std::copy(part, part + here, to_hi + i);
      }
    };
    enlarge(lo0, hi0, p0, q0, larger.lo(0), larger.hi(0));
    enlarge(lo1, hi1, p1, q1, larger.lo(1), larger.hi(1));
    enlarge(lo2, hi2, p2, q2, larger.lo(2), larger.hi(2));
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(copy_boxes);
HWY_EXPORT(enlarge_boxes);
HWY_EXPORT(overlapping);

std::size_t copy_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray* within,
                       BoxRecord* records, std::uint32_t* outside) {
  return HWY_DYNAMIC_DISPATCH(copy_boxes)(boxes, begin, end, within, records, outside);
}

void enlarge_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxRecord* past, float steps,
                   float usual, BoxArray& larger) {
  HWY_DYNAMIC_DISPATCH(enlarge_boxes)(boxes, begin, end, past, steps, usual, larger);
}

std::size_t overlapping(const BoxRecord* records, const Pair* pairs, std::size_t count, Pair* out) {
  return HWY_DYNAMIC_DISPATCH(overlapping)(records, pairs, count, out);
}
}  // namespace tandem
#endif
