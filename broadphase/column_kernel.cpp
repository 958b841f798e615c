#include "column_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "column_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::size_t overlap_column(const Column& column, std::size_t& row, std::uint32_t* a, std::uint32_t* b,
                           std::size_t room) {
  const hn::ScalableTag<float> df;
  const hn::RebindToUnsigned<decltype(df)> du;
  const std::size_t lanes = hn::Lanes(df);
  const BoxArray& boxes = *column.boxes;
  const float *blo0 = boxes.lo(0), *blo1 = boxes.lo(1), *blo2 = boxes.lo(2);
  const float *bhi0 = boxes.hi(0), *bhi1 = boxes.hi(1), *bhi2 = boxes.hi(2);
  const auto both = hn::Set(du, 3u);

  std::size_t count = 0, i = row;
  for (; i < column.size; ++i) {
    const std::size_t end = column.end[i];
    if (end <= i + 1) continue;
    if (count + (end - i) + BoxArray::padding > room) break;
    const auto lo0 = hn::Set(df, blo0[i]), hi0 = hn::Set(df, bhi0[i]);
    const auto lo1 = hn::Set(df, blo1[i]), hi1 = hn::Set(df, bhi1[i]);
    const auto lo2 = hn::Set(df, blo2[i]), hi2 = hn::Set(df, bhi2[i]);
    const auto own = hn::Set(du, column.index[i]), first = hn::Set(du, column.first[i]);
    for (std::size_t j = i + 1; j < end; j += lanes) {
      const auto x = hn::And(hn::Le(hn::LoadU(df, blo0 + j), hi0), hn::Le(lo0, hn::LoadU(df, bhi0 + j)));
      const auto y = hn::And(hn::Le(hn::LoadU(df, blo1 + j), hi1), hn::Le(lo1, hn::LoadU(df, bhi1 + j)));
      const auto z = hn::And(hn::Le(hn::LoadU(df, blo2 + j), hi2), hn::Le(lo2, hn::LoadU(df, bhi2 + j)));
      const auto here = hn::Eq(hn::Or(first, hn::LoadU(du, column.first + j)), both);
      auto hit = hn::And(hn::And(x, y), hn::And(z, hn::RebindMask(df, here)));
      if (hn::AllFalse(df, hit)) continue;
      // The last vector may reach into rows that are not asked for.
      if (j + lanes > end) hit = hn::And(hit, hn::FirstN(df, end - j));
      hn::StoreU(own, du, a + count);
      count += hn::CompressStore(hn::LoadU(du, column.index + j), hn::RebindMask(du, hit), du, b + count);
    }
  }
  row = i;
  return count;
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
void slices_of(const Slices& slices, const float* coordinates, std::size_t count, std::uint16_t* out) {
  const hn::ScalableTag<float> df;
  const hn::RebindToSigned<decltype(df)> di;
  const hn::Rebind<std::uint16_t, decltype(df)> d16;
  const auto half = hn::Set(df, 0.5f), origin = hn::Set(df, slices.half_origin);
  const auto inverse = hn::Set(df, slices.inverse_half_width), last = hn::Set(df, static_cast<float>(slices.count - 1));
  for (std::size_t i = 0; i < count; i += hn::Lanes(df)) {
    const auto place = hn::Mul(hn::Sub(hn::Mul(half, hn::LoadU(df, coordinates + i)), origin), inverse);
    const auto inside = hn::Min(hn::IfThenElseZero(hn::Gt(place, hn::Zero(df)), place), last);
    hn::StoreU(hn::DemoteTo(d16, hn::ConvertTo(di, inside)), d16, out + i);
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(overlap_column);
HWY_EXPORT(slices_of);

void slices_of(const Slices& slices, const float* coordinates, std::size_t count, std::uint16_t* out) {
  HWY_DYNAMIC_DISPATCH(slices_of)(slices, coordinates, count, out);
}

std::size_t overlap_column(const Column& column, std::size_t& row, std::uint32_t* a, std::uint32_t* b,
                           std::size_t room) {
  return HWY_DYNAMIC_DISPATCH(overlap_column)(column, row, a, b, room);
}
}  // namespace tandem
#endif
