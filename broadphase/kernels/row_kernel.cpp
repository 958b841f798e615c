// Vector kernels that test one box against a row of boxes, compiled once for each instruction set.
#include "kernels/row_kernel.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/row_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::size_t overlap_row(const BoxArray& boxes, std::size_t begin, std::size_t end, const Aabb& box,
                        std::uint32_t* out) {
  const hn::ScalableTag<float> df;
  const std::size_t lanes = hn::Lanes(df);

  const auto lo0 = hn::Set(df, box.lo[0]), hi0 = hn::Set(df, box.hi[0]);
  const auto lo1 = hn::Set(df, box.lo[1]), hi1 = hn::Set(df, box.hi[1]);
  const auto lo2 = hn::Set(df, box.lo[2]), hi2 = hn::Set(df, box.hi[2]);
  const float *blo0 = boxes.lo(0), *blo1 = boxes.lo(1), *blo2 = boxes.lo(2);
  const float *bhi0 = boxes.hi(0), *bhi1 = boxes.hi(1), *bhi2 = boxes.hi(2);

  std::size_t count = 0;
  for (std::size_t j = begin; j < end; j += lanes) {
    const auto x = hn::And(hn::Le(hn::LoadU(df, blo0 + j), hi0), hn::Le(lo0, hn::LoadU(df, bhi0 + j)));
    const auto y = hn::And(hn::Le(hn::LoadU(df, blo1 + j), hi1), hn::Le(lo1, hn::LoadU(df, bhi1 + j)));
    const auto z = hn::And(hn::Le(hn::LoadU(df, blo2 + j), hi2), hn::Le(lo2, hn::LoadU(df, bhi2 + j)));
    auto hit = hn::And(x, hn::And(y, z));
    if (hn::AllFalse(df, hit)) continue;
    // The last vector may reach beyond `end`.
    if (j + lanes > end) hit = hn::And(hit, hn::FirstN(df, end - j));
    // Not by CompressStore, for which g++ 12 copies a table of 1 KiB at each call.
    std::uint64_t bits = 0;
    hn::StoreMaskBits(df, hit, reinterpret_cast<std::uint8_t*>(&bits));
    for (; bits != 0; bits &= bits - 1)
      out[count++] = static_cast<std::uint32_t>(j + static_cast<std::size_t>(std::countr_zero(bits)));
  }
  return count;
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::size_t near_row(const BoxArray& boxes, std::size_t begin, std::size_t end, const Aabb& box, double most,
                     std::uint32_t* out, double* squared) {
  const hn::ScalableTag<double> dd;
  const hn::Rebind<float, decltype(dd)> df;
  const std::size_t lanes = hn::Lanes(dd);
  const auto at_most = hn::Set(dd, std::min(most, std::numeric_limits<double>::max()));
  alignas(64) double sums[hn::MaxLanes(dd)];
  std::size_t count = 0;
  for (std::size_t j = begin; j < end; j += lanes) {
    auto sum = hn::Zero(dd);
    for (int k = 0; k < 3; ++k) {
      const auto lo = hn::Set(dd, double{box.lo[static_cast<std::size_t>(k)]});
      const auto hi = hn::Set(dd, double{box.hi[static_cast<std::size_t>(k)]});
      const auto above = hn::Sub(hn::PromoteTo(dd, hn::LoadU(df, boxes.lo(k) + j)), hi);
      const auto below = hn::Sub(lo, hn::PromoteTo(dd, hn::LoadU(df, boxes.hi(k) + j)));
      const auto off = hn::Max(hn::Max(above, below), hn::Zero(dd));
      sum = hn::Add(sum, hn::Mul(off, off));
    }
    auto near = hn::Le(sum, at_most);
    if (j + lanes > end) near = hn::And(near, hn::FirstN(dd, end - j));
    std::uint64_t bits = 0;
    hn::StoreMaskBits(dd, near, reinterpret_cast<std::uint8_t*>(&bits));
    if (bits == 0) continue;
    hn::Store(sum, dd, sums);
    for (; bits != 0; bits &= bits - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(bits));
      squared[count] = sums[lane];
      out[count++] = static_cast<std::uint32_t>(j + lane);
    }
  }
  return count;
}

// Rows end with empty boxes, which change no bound.
// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void unite_rows(const BoxArray& below, std::size_t first, std::size_t last, BoxArray& above) {
  const hn::CappedTag<float, 8> df;
  const std::size_t lanes = hn::Lanes(df);
  for (int k = 0; k < 3; ++k) {
    const float *lo = below.lo(k), *hi = below.hi(k);
    float *out_lo = above.lo(k), *out_hi = above.hi(k);
    for (std::size_t node = first; node < last; ++node) {
      auto least = hn::LoadU(df, lo + 8 * node), most = hn::LoadU(df, hi + 8 * node);
      for (std::size_t j = lanes; j < 8; j += lanes) {
        least = hn::Min(least, hn::LoadU(df, lo + 8 * node + j));
        most = hn::Max(most, hn::LoadU(df, hi + 8 * node + j));
      }
      out_lo[node] = hn::GetLane(hn::MinOfLanes(df, least));
      out_hi[node] = hn::GetLane(hn::MaxOfLanes(df, most));
    }
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(overlap_row);
HWY_EXPORT(near_row);
HWY_EXPORT(unite_rows);

std::size_t overlap_row(const BoxArray& boxes, std::size_t begin, std::size_t end, const Aabb& box,
                        std::uint32_t* out) {
  return HWY_DYNAMIC_DISPATCH(overlap_row)(boxes, begin, end, box, out);
}
std::size_t near_row(const BoxArray& boxes, std::size_t begin, std::size_t end, const Aabb& box, double most,
                     std::uint32_t* out, double* squared) {
  return HWY_DYNAMIC_DISPATCH(near_row)(boxes, begin, end, box, most, out, squared);
}
void unite_rows(const BoxArray& below, std::size_t first, std::size_t last, BoxArray& above) {
  HWY_DYNAMIC_DISPATCH(unite_rows)(below, first, last, above);
}
}  // namespace tandem
#endif
