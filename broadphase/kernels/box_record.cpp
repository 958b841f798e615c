// Vector kernels over boxes and box records, compiled once for each instruction set (Highway).
#include "kernels/box_record.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <bit>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/box_record.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// From so many boxes on, records are hardly in a cache any more when they are read, so they are written past the
// caches.
constexpr std::size_t least_streamed = 500'000;

// The four boxes of a vector as rows, transposed from one array a bound.
struct Rows {
  HWY_ALIGN float lo[4 * hn::MaxLanes(hn::ScalableTag<float>())], hi[4 * hn::MaxLanes(hn::ScalableTag<float>())];

  template <class V>
  HWY_INLINE void set(V lo0, V lo1, V lo2, V hi0, V hi1, V hi2) {
    const hn::ScalableTag<float> df;
    hn::StoreInterleaved4(lo0, lo1, lo2, hn::Zero(df), df, lo);
    hn::StoreInterleaved4(hi0, hi1, hi2, hn::Zero(df), df, hi);
  }
  HWY_INLINE void copy(std::size_t k, BoxRecord& record) const {
    const hn::CappedTag<float, 4> quad;
    for (std::size_t axis = 0; axis < 4; axis += hn::Lanes(quad)) {
      hn::Store(hn::Load(quad, lo + 4 * k + axis), quad, record.lo() + axis);
      hn::Store(hn::Load(quad, hi + 4 * k + axis), quad, record.hi() + axis);
    }
  }
  /// Stores a box's record past the caches.
  HWY_INLINE void stream(std::size_t k, BoxRecord& record) const {
    const hn::CappedTag<float, 4> quad;
    for (std::size_t axis = 0; axis < 4; axis += hn::Lanes(quad)) {
      hn::Stream(hn::Load(quad, lo + 4 * k + axis), quad, record.lo() + axis);
      hn::Stream(hn::Load(quad, hi + 4 * k + axis), quad, record.hi() + axis);
    }
  }
};

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void copy_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, BoxRecord* records) {
  const hn::ScalableTag<float> df;
  const std::size_t lanes = hn::Lanes(df);
  const float *from_lo0 = boxes.lo(0), *from_lo1 = boxes.lo(1), *from_lo2 = boxes.lo(2);
  const float *from_hi0 = boxes.hi(0), *from_hi1 = boxes.hi(1), *from_hi2 = boxes.hi(2);
  const bool streams = boxes.size() >= least_streamed;
  Rows rows;
  for (std::size_t i = begin; i < end; i += lanes) {
    rows.set(hn::LoadU(df, from_lo0 + i), hn::LoadU(df, from_lo1 + i), hn::LoadU(df, from_lo2 + i),
             hn::LoadU(df, from_hi0 + i), hn::LoadU(df, from_hi1 + i), hn::LoadU(df, from_hi2 + i));
    const std::size_t here = end - i < lanes ? end - i : lanes;
    if (streams)
      for (std::size_t k = 0; k < here; ++k) rows.stream(k, records[i + k]);
    else
      for (std::size_t k = 0; k < here; ++k) rows.copy(k, records[i + k]);
  }
  if (streams) hwy::FlushStream();
}

// Goes axis by axis over some boxes at a time: twelve arrays read side by side are more than the hardware prefetchers
// follow. NOLINTNEXTLINE(misc-definitions-in-headers)
std::size_t copy_boxes_that_left(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray& within,
                                 BoxRecord* records, std::uint32_t* outside, BoxRecord* before) {
  const hn::CappedTag<float, 16> df;
  const std::size_t lanes = hn::Lanes(df);
  constexpr std::size_t boxes_at_once = 2048;
  std::uint16_t out[boxes_at_once];  // bits of each vector
  std::size_t count = 0;
  for (std::size_t first = begin; first < end; first += boxes_at_once) {
    const std::size_t last = end - first < boxes_at_once ? end : first + boxes_at_once;
    std::uint32_t any = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const float *lo = boxes.lo(axis), *hi = boxes.hi(axis), *least = within.lo(axis), *most = within.hi(axis);
      std::uint16_t* bits = out;
      for (std::size_t i = first; i < last; i += lanes, ++bits) {
        const auto inside = hn::And(hn::Le(hn::LoadU(df, least + i), hn::LoadU(df, lo + i)),
                                    hn::Le(hn::LoadU(df, hi + i), hn::LoadU(df, most + i)));
        std::uint8_t bytes[8] = {};
        hn::StoreMaskBits(df, hn::Not(inside), bytes);
        const std::uint32_t here = bytes[0] | static_cast<std::uint32_t>(bytes[1]) << 8;
        *bits = static_cast<std::uint16_t>(axis == 0 ? here : *bits | here);
        any |= here;
      }
    }
    if (any != 0) {
      for (std::size_t i = first; i < last; i += lanes) {
        std::uint32_t bits = out[(i - first) / lanes];
        if (last - i < lanes) bits &= (1u << (last - i)) - 1;
        // Not by CompressStore, for which g++ 12 copies a table of 1 KiB at each call.
        for (; bits != 0; bits &= bits - 1) {
          const std::size_t left = i + static_cast<std::size_t>(std::countr_zero(bits));
          if (records != nullptr) before[count] = records[left];
          outside[count++] = static_cast<std::uint32_t>(left);
        }
      }
    }
    if (records != nullptr) HWY_NAMESPACE::copy_boxes(boxes, first, last, records);
  }
  return count;
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
std::size_t count_boxes_that_left(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray& within) {
  const hn::CappedTag<float, 16> df;
  const std::size_t lanes = hn::Lanes(df);
  std::size_t count = 0;
  for (std::size_t i = begin; i < end; i += lanes) {
    auto all_inside = hn::FirstN(df, lanes);
    for (int axis = 0; axis < 3; ++axis) {
      const auto inside = hn::And(hn::Le(hn::LoadU(df, within.lo(axis) + i), hn::LoadU(df, boxes.lo(axis) + i)),
                                  hn::Le(hn::LoadU(df, boxes.hi(axis) + i), hn::LoadU(df, within.hi(axis) + i)));
      all_inside = hn::And(all_inside, inside);
    }
    count += hn::CountTrue(df, hn::And(hn::FirstN(df, end - i), hn::Not(all_inside)));
  }
  return count;
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
std::size_t count_set(std::span<const std::uint8_t> bytes) {
  const hn::ScalableTag<std::uint8_t> d;
  std::size_t count = 0, i = 0;
  for (; i + hn::Lanes(d) <= bytes.size(); i += hn::Lanes(d))
    count += hn::CountTrue(d, hn::Ne(hn::LoadU(d, bytes.data() + i), hn::Zero(d)));
  for (; i < bytes.size(); ++i) count += bytes[i] != 0 ? 1 : 0;
  return count;
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
std::size_t indices_set(std::span<const std::uint8_t> bytes, std::size_t begin, std::size_t end, std::uint32_t* out) {
  const hn::CappedTag<std::uint8_t, 64> d;
  std::size_t count = 0, i = begin;
  for (; i + hn::Lanes(d) <= end; i += hn::Lanes(d)) {
    std::uint64_t bits = 0;
    hn::StoreMaskBits(d, hn::Ne(hn::LoadU(d, bytes.data() + i), hn::Zero(d)), reinterpret_cast<std::uint8_t*>(&bits));
    for (; bits != 0; bits &= bits - 1)
      out[count++] = static_cast<std::uint32_t>(i) + static_cast<std::uint32_t>(std::countr_zero(bits));
  }
  for (; i < end; ++i) {
    out[count] = static_cast<std::uint32_t>(i);
    count += bytes[i] != 0 ? 1 : 0;
  }
  return count;
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
void gather_records(const BoxRecord* records, const std::uint32_t* bodies, std::size_t count, BoxRecord* out) {
  constexpr std::size_t ahead = 32;
  const hn::CappedTag<float, 8> d;
  const auto copy = [&](std::size_t k) HWY_ATTR {
    for (std::size_t at = 0; at < 8; at += hn::Lanes(d))
      hn::Store(hn::Load(d, records[bodies[k]].bounds + at), d, out[k].bounds + at);
  };
  std::size_t k = 0;
  for (; k + ahead < count; ++k) {
    hwy::Prefetch(records + bodies[k + ahead]);
    copy(k);
  }
  for (; k < count; ++k) copy(k);
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
std::size_t overlapping(const BoxRecord* records, const LocalPair* pairs, std::size_t count, LocalPair* out) {
  const hn::CappedTag<float, 4> d;
  std::size_t hits = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const LocalPair pair = pairs[i];
    const BoxRecord &a = records[pair.a], &b = records[pair.b];
    bool hit = true;
    for (std::size_t axis = 0; axis < 4; axis += hn::Lanes(d)) {
      const auto below = hn::Le(hn::Load(d, a.lo() + axis), hn::Load(d, b.hi() + axis));
      const auto above = hn::Le(hn::Load(d, b.lo() + axis), hn::Load(d, a.hi() + axis));
      hit = hit & hn::AllTrue(d, hn::And(below, above));
    }
    out[hits] = pair;  // without a branch, since which pairs overlap is unpredictable
    hits += hit ? 1 : 0;
  }
  return hits;
}

using Floats = hn::ScalableTag<float>;
using V = hn::Vec<Floats>;

// Fraction of its edge by which a box is enlarged on each side: with less, bodies that shake leave their boxes; with
// more, lists have more candidates.
constexpr float enlarged_share = 0.02f;

// The parameters of enlarging, for the boxes of a vector.
struct BoxEnlarging {
  V share, most_grown, ahead, sweep;
  hn::Mask<Floats> goes_on, bounded;

  /// Replaces the bounds on one axis by those of the enlarged boxes, given the bounds in the step before.
  HWY_INLINE void enlarge(V& lo, V& hi, V past_lo, V past_hi) const {
    const Floats df;
    const V zero = hn::Zero(df), most = hn::Set(df, std::numeric_limits<float>::max());
    const V lo_step = hn::IfThenElseZero(goes_on, hn::Sub(lo, past_lo));
    const V hi_step = hn::IfThenElseZero(goes_on, hn::Sub(hi, past_hi));
    // Far from the origin rounding alone moves a box by its last bit, so the box grows at least by that.
    const V last_bit = hn::Mul(hn::Set(df, std::numeric_limits<float>::epsilon()), hn::Max(hn::Abs(lo), hn::Abs(hi)));
    const V grow = hn::Add(hn::Add(hn::Min(hn::Mul(share, hn::Sub(hi, lo)), most_grown),
                                   hn::Mul(hn::Set(df, 0.25f), hn::Max(hn::Abs(lo_step), hn::Abs(hi_step)))),
                           last_bit);
    const V down = hn::Min(hn::Max(hn::Mul(lo_step, ahead), hn::Neg(sweep)), zero);
    const V up = hn::Max(hn::Min(hn::Mul(hi_step, ahead), sweep), zero);
    lo = hn::IfThenElse(bounded, hn::Max(hn::Sub(hn::Add(lo, down), grow), hn::Neg(most)), lo);
    hi = hn::IfThenElse(bounded, hn::Min(hn::Add(hn::Add(hi, up), grow), most), hi);
  }
};

// A vector of records, read as one vector for each bound.
struct RecordColumns {
  HWY_ALIGN float all_lo[4 * hn::MaxLanes(Floats())] = {}, all_hi[4 * hn::MaxLanes(Floats())] = {};

  HWY_INLINE void load(const BoxRecord* records, std::size_t count, V* lo, V* hi) {
    const Floats df;
    const hn::CappedTag<float, 4> quad;
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t axis = 0; axis < 4; axis += hn::Lanes(quad)) {
        hn::Store(hn::Load(quad, records[k].lo() + axis), quad, all_lo + 4 * k + axis);
        hn::Store(hn::Load(quad, records[k].hi() + axis), quad, all_hi + 4 * k + axis);
      }
    }
    V unused;
    hn::LoadInterleaved4(df, all_lo, lo[0], lo[1], lo[2], unused);
    hn::LoadInterleaved4(df, all_hi, hi[0], hi[1], hi[2], unused);
  }
};

// NOLINTNEXTLINE(misc-definitions-in-headers)
void enlarge_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxRecord* past, float steps,
                   const UsualBox& usual, BoxArray& larger) {
  const Floats df;
  const std::size_t lanes = hn::Lanes(df);
  const V half = hn::Set(df, 0.5f), most = hn::Set(df, std::numeric_limits<float>::max());
  const V least_sweep = hn::Set(df, usual.motion * steps), usual_motion = hn::Set(df, usual.motion);
  BoxEnlarging x;
  x.share = hn::Set(df, enlarged_share);
  x.most_grown = hn::Set(df, std::max(enlarged_share * usual.edge, usual.motion));
  x.ahead = hn::Set(df, steps);

  // Behind the end may be another block's boxes, so only the used lanes of the last vector are stored.
  HWY_ALIGN float part[hn::MaxLanes(df)];
  RecordColumns records;
  for (std::size_t i = begin; i < end; i += lanes) {
    const std::size_t here = end - i < lanes ? end - i : lanes;
    V past_lo[3], past_hi[3], lo[3], hi[3];
    records.load(past + i, here, past_lo, past_hi);
    for (int axis = 0; axis < 3; ++axis) {
      lo[axis] = hn::LoadU(df, boxes.lo(axis) + i);
      hi[axis] = hn::LoadU(df, boxes.hi(axis) + i);
    }
    const V size = hn::Max(hn::Sub(hi[0], lo[0]), hn::Max(hn::Sub(hi[1], lo[1]), hn::Sub(hi[2], lo[2])));
    const auto farther = [&](int axis) HWY_ATTR {
      return hn::Max(hn::Abs(hn::Sub(lo[axis], past_lo[axis])), hn::Abs(hn::Sub(hi[axis], past_hi[axis])));
    };
    const V motion = hn::Max(farther(0), hn::Max(farther(1), farther(2)));
    x.goes_on = hn::Le(motion, hn::Max(hn::Mul(half, size), usual_motion));
    x.bounded = hn::And(hn::Lt(size, most), hn::Le(lo[0], hi[0]));
    x.sweep = hn::Max(size, least_sweep);
    const auto store = [&](V values, float* to) HWY_ATTR {
      if (here == lanes) return hn::StoreU(values, df, to + i);
      hn::Store(values, df, part);
      std::copy(part, part + here, to + i);
    };
    for (int axis = 0; axis < 3; ++axis) {
      x.enlarge(lo[axis], hi[axis], past_lo[axis], past_hi[axis]);
      store(lo[axis], larger.lo(axis));
      store(hi[axis], larger.hi(axis));
    }
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(copy_boxes);
HWY_EXPORT(copy_boxes_that_left);
HWY_EXPORT(count_boxes_that_left);
HWY_EXPORT(count_set);
HWY_EXPORT(enlarge_boxes);
HWY_EXPORT(gather_records);
HWY_EXPORT(indices_set);
HWY_EXPORT(overlapping);

void copy_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, BoxRecord* records) {
  HWY_DYNAMIC_DISPATCH(copy_boxes)(boxes, begin, end, records);
}

std::size_t copy_boxes_that_left(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray& within,
                                 BoxRecord* records, std::uint32_t* outside, BoxRecord* before) {
  return HWY_DYNAMIC_DISPATCH(copy_boxes_that_left)(boxes, begin, end, within, records, outside, before);
}

std::size_t count_boxes_that_left(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxArray& within) {
  return HWY_DYNAMIC_DISPATCH(count_boxes_that_left)(boxes, begin, end, within);
}

void enlarge_boxes(const BoxArray& boxes, std::size_t begin, std::size_t end, const BoxRecord* past, float steps,
                   const UsualBox& usual, BoxArray& larger) {
  HWY_DYNAMIC_DISPATCH(enlarge_boxes)(boxes, begin, end, past, steps, usual, larger);
}

std::size_t count_set(std::span<const std::uint8_t> bytes) { return HWY_DYNAMIC_DISPATCH(count_set)(bytes); }

std::size_t indices_set(std::span<const std::uint8_t> bytes, std::size_t begin, std::size_t end, std::uint32_t* out) {
  return HWY_DYNAMIC_DISPATCH(indices_set)(bytes, begin, end, out);
}

void gather_records(const BoxRecord* records, const std::uint32_t* bodies, std::size_t count, BoxRecord* out) {
  HWY_DYNAMIC_DISPATCH(gather_records)(records, bodies, count, out);
}

void gather_boxes(const BoxArray& boxes, const std::uint32_t* bodies, std::size_t count, BoxRecord* out) {
  constexpr std::size_t ahead = 16;
  for (std::size_t k = 0; k < count; ++k) {
    if (k + ahead < count) prefetch_box(boxes, bodies[k + ahead]);
    out[k].set(boxes[bodies[k]]);
  }
}

std::size_t overlapping(const BoxRecord* records, const LocalPair* pairs, std::size_t count, LocalPair* out) {
  return HWY_DYNAMIC_DISPATCH(overlapping)(records, pairs, count, out);
}
}  // namespace tandem
#endif
