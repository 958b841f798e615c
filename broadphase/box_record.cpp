#include "box_record.h"

#include <hwy/cache_control.h>

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

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(copy_boxes);
HWY_EXPORT(overlapping);

std::size_t copy_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray* within,
                       BoxRecord* records, std::uint32_t* outside) {
  return HWY_DYNAMIC_DISPATCH(copy_boxes)(boxes, begin, end, within, records, outside);
}

std::size_t overlapping(const BoxRecord* records, const Pair* pairs, std::size_t count, Pair* out) {
  return HWY_DYNAMIC_DISPATCH(overlapping)(records, pairs, count, out);
}
}  // namespace tandem
#endif
