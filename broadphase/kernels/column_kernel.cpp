// Vector kernels of the grid: sort the boxes of a column and test its rows, compiled once for each instruction set.
#include "kernels/column_kernel.h"

#include <bit>
#include <limits>

#include "storage/memory.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/column_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// At most 16 lanes, so that a vector's hits are two bytes.
using Floats = hn::CappedTag<float, 16>;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void scatter_records(const BoxArray& boxes, std::size_t begin, const ColumnEntry* entries, std::size_t count,
                     std::uint32_t* place, ColumnRecord* records) {
  const Floats df;
  const hn::RebindToUnsigned<decltype(df)> du;
  HWY_ALIGN float front[4 * max_boxes_a_scatter + 4 * hn::MaxLanes(df)];
  HWY_ALIGN float back[4 * max_boxes_a_scatter + 4 * hn::MaxLanes(df)];
  const std::size_t boxes_end = count == 0 ? 0 : entries[count - 1].box + std::size_t{1};
  for (std::size_t k = 0; k < boxes_end; k += hn::Lanes(df)) {
    const auto load = [&](const float* values) HWY_ATTR { return hn::LoadU(df, values + begin + k); };
    const auto index = hn::BitCast(df, hn::Iota(du, static_cast<std::uint32_t>(begin + k)));
    hn::StoreInterleaved4(load(boxes.lo(0)), load(boxes.lo(1)), load(boxes.lo(2)), load(boxes.hi(0)), df,
                          front + 4 * k);
    hn::StoreInterleaved4(load(boxes.hi(1)), load(boxes.hi(2)), index, hn::Zero(df), df, back + 4 * k);
  }
  constexpr std::size_t ahead = 16;
  for (std::size_t e = 0; e < count; ++e) {
    if (e + ahead < count) __builtin_prefetch(records + place[entries[e + ahead].column], 1, 3);
    const ColumnEntry entry = entries[e];
    ColumnRecord& record = records[place[entry.column]++];
    hwy::CopyBytes<16>(front + 4 * std::size_t{entry.box}, &record);
    hwy::CopyBytes<16>(back + 4 * std::size_t{entry.box}, reinterpret_cast<float*>(&record) + 4);
    record.first = entry.first;
  }
}

// A counting sort of the records by their lower bounds into about as many thin cells as there are rows: computes the
// cell of each record, and where each cell begins.
HWY_INLINE void count_cells(const ColumnRecord* records, std::size_t size, std::size_t axis, Column& column) {
  float lo = records[0].box.lo[axis], hi = lo;
  for (std::size_t i = 1; i < size; ++i) {
    lo = std::min(lo, records[i].box.lo[axis]);
    hi = std::max(hi, records[i].box.lo[axis]);
  }
  const std::size_t cells = std::bit_ceil(size);
  const double width = (double{hi} - double{lo}) / static_cast<double>(cells);
  const Slices slices{axis, 0.5f * lo, width > 0 ? static_cast<float>(std::min(2 / width, 1e38)) : 0,
                      static_cast<std::uint32_t>(cells)};
  column.cells = slices;
  column.cell_end.assign(cells, 0);
  std::uint32_t *cell = column.cell.data(), *place = column.cell_end.data();
  for (std::size_t i = 0; i < size; ++i) ++place[cell[i] = slices.at(records[i].box.lo[axis])];
  std::uint32_t sum = 0;
  for (std::size_t k = 0; k < cells; ++k) {
    const std::uint32_t count = place[k];
    place[k] = sum;
    sum += count;
  }
}

// Fills the sorted rows: bounds in arrays, and the cell in which each row ends.
HWY_INLINE void fill_rows(Column& column, std::size_t axis) {
  const Floats df;
  const hn::RebindToUnsigned<decltype(df)> du;
  const std::size_t size = column.size, lanes = hn::Lanes(df);
  const Slices& slices = column.cells;
  const float *front = column.front.data(), *back = column.back.data();
  const std::array<float*, 6> to{column.bounds[0].data(), column.bounds[1].data(), column.bounds[2].data(),
                                 column.bounds[3].data(), column.bounds[4].data(), column.bounds[5].data()};
  const auto half = hn::Set(df, 0.5f), origin = hn::Set(df, slices.half_origin);
  const auto inverse = hn::Set(df, slices.inverse_half_width),
             most = hn::Set(df, static_cast<float>(column.cell_end.size() - 1));
  const hn::RebindToSigned<decltype(df)> di;
  auto longest = hn::Zero(di);
  for (std::size_t row = 0; row < size; row += lanes) {
    hn::Vec<decltype(df)> lo0, lo1, lo2, hi0, hi1, hi2, index, first;
    hn::LoadInterleaved4(df, front + 4 * row, lo0, lo1, lo2, hi0);
    hn::LoadInterleaved4(df, back + 4 * row, hi1, hi2, index, first);
    hn::StoreU(lo0, df, to[0] + row);
    hn::StoreU(lo1, df, to[1] + row);
    hn::StoreU(lo2, df, to[2] + row);
    hn::StoreU(hi0, df, to[3] + row);
    hn::StoreU(hi1, df, to[4] + row);
    hn::StoreU(hi2, df, to[5] + row);
    hn::StoreU(hn::BitCast(du, index), du, column.index.data() + row);
    hn::StoreU(hn::BitCast(du, first), du, column.first.data() + row);
    const auto cell_of = [&](hn::Vec<decltype(df)> x) HWY_ATTR {
      const auto at = hn::Mul(hn::Sub(hn::Mul(half, x), origin), inverse);
      return hn::ConvertTo(di, hn::Min(hn::IfThenElseZero(hn::Gt(at, hn::Zero(df)), at), most));
    };
    const auto last = cell_of(axis == 0 ? hi0 : axis == 1 ? hi1 : hi2);
    longest = hn::Max(longest, hn::Sub(last, cell_of(axis == 0 ? lo0 : axis == 1 ? lo1 : lo2)));
    hn::StoreU(hn::BitCast(du, last), du, column.last.data() + row);
  }
  column.longest = static_cast<std::uint32_t>(hn::GetLane(hn::MaxOfLanes(di, longest)));
  constexpr float inf = std::numeric_limits<float>::infinity();
  for (std::size_t k = 0; k < 6; ++k) hn::StoreU(hn::Set(df, k < 3 ? inf : -inf), df, to[k] + size);
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
void sort_column(const ColumnRecord* records, std::size_t size, std::size_t axis, Column& column) {
  const std::size_t lanes = hn::Lanes(Floats()), padded = size + 2 * lanes;
  for (auto& bound : column.bounds)
    if (bound.size() < padded) bound.resize(padded);
  for (auto* values : {&column.index, &column.first, &column.cell, &column.last})
    if (values->size() < padded) values->resize(padded);
  for (auto* half : {&column.front, &column.back})
    if (half->size() < 4 * padded) half->resize(4 * padded);
  column.size = size;
  count_cells(records, size, axis, column);
  const std::uint32_t* cell = column.cell.data();
  std::uint32_t* place = column.cell_end.data();
  float *front = column.front.data(), *back = column.back.data();
  std::fill(front + 4 * size, front + 4 * (size + lanes), 0.0f);
  std::fill(back + 4 * size, back + 4 * (size + lanes), 0.0f);
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t row = place[cell[i]]++;  // after the loop each begin is the end of its cell
    hwy::CopyBytes<16>(&records[i], front + 4 * row);
    hwy::CopyBytes<16>(reinterpret_cast<const float*>(&records[i]) + 4, back + 4 * row);
  }
  fill_rows(column, axis);
}

// NOLINTNEXTLINE(misc-definitions-in-headers)
std::size_t overlap_column(const Column& column, std::size_t& row, RowHits* hits, std::size_t room) {
  const Floats df;
  const hn::RebindToUnsigned<decltype(df)> du;
  const std::size_t lanes = hn::Lanes(df);
  const float *blo0 = column.bounds[0].data(), *blo1 = column.bounds[1].data(), *blo2 = column.bounds[2].data();
  const float *bhi0 = column.bounds[3].data(), *bhi1 = column.bounds[4].data(), *bhi2 = column.bounds[5].data();
  const std::uint32_t *firsts = column.first.data(), *lasts = column.last.data(), *cell_end = column.cell_end.data();
  const auto both = hn::Set(du, 3u);

  std::size_t count = 0, i = row;
  for (; i < column.size; ++i) {
    const std::size_t end = cell_end[lasts[i]];
    if (count + (end - i) / lanes + 1 > room) break;
    const auto lo0 = hn::Set(df, blo0[i]), hi0 = hn::Set(df, bhi0[i]);
    const auto lo1 = hn::Set(df, blo1[i]), hi1 = hn::Set(df, bhi1[i]);
    const auto lo2 = hn::Set(df, blo2[i]), hi2 = hn::Set(df, bhi2[i]);
    const auto first = hn::Set(du, firsts[i]);
    std::size_t j = i + 1;
    do {
      const auto x = hn::And(hn::Le(hn::LoadU(df, blo0 + j), hi0), hn::Le(lo0, hn::LoadU(df, bhi0 + j)));
      const auto y = hn::And(hn::Le(hn::LoadU(df, blo1 + j), hi1), hn::Le(lo1, hn::LoadU(df, bhi1 + j)));
      const auto z = hn::And(hn::Le(hn::LoadU(df, blo2 + j), hi2), hn::Le(lo2, hn::LoadU(df, bhi2 + j)));
      const auto here = hn::Eq(hn::Or(first, hn::LoadU(du, firsts + j)), both);
      const auto hit = hn::And(hn::And(x, y), hn::And(z, hn::RebindMask(df, here)));
      std::uint8_t bytes[8];
      hn::StoreMaskBits(df, hit, bytes);
      std::uint32_t bits = bytes[0];
      if constexpr (hn::MaxLanes(Floats{}) > 8) bits |= static_cast<std::uint32_t>(bytes[1]) << 8;
      hits[count] = {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(j), bits};
      count += bits != 0 ? 1 : 0;
      j += lanes;
    } while (j < end);
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

// NOLINTNEXTLINE(misc-definitions-in-headers)
std::size_t boxes_in_slab(const BoxArray& boxes, std::size_t axis, float begin, float end, std::size_t most,
                          std::uint32_t* out) {
  const hn::ScalableTag<float> df;
  const std::size_t lanes = hn::Lanes(df);
  const float *lo = boxes.lo(static_cast<int>(axis)), *hi = boxes.hi(static_cast<int>(axis));
  const auto from = hn::Set(df, begin), to = hn::Set(df, end);
  std::size_t count = 0;
  for (std::size_t i = 0; i < boxes.size() && count <= most; i += lanes) {
    const auto in = hn::And(hn::Lt(hn::LoadU(df, lo + i), to), hn::Le(from, hn::LoadU(df, hi + i)));
    std::uint64_t bits = 0;
    hn::StoreMaskBits(df, in, reinterpret_cast<std::uint8_t*>(&bits));
    for (; bits != 0; bits &= bits - 1)
      out[count++] = static_cast<std::uint32_t>(i) + static_cast<std::uint32_t>(std::countr_zero(bits));
  }
  return count;
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(boxes_in_slab);
HWY_EXPORT(overlap_column);
HWY_EXPORT(scatter_records);
HWY_EXPORT(slices_of);
HWY_EXPORT(sort_column);

void slices_of(const Slices& slices, const float* coordinates, std::size_t count, std::uint16_t* out) {
  HWY_DYNAMIC_DISPATCH(slices_of)(slices, coordinates, count, out);
}

void scatter_records(const BoxArray& boxes, std::size_t begin, const ColumnEntry* entries, std::size_t count,
                     std::uint32_t* place, ColumnRecord* records) {
  HWY_DYNAMIC_DISPATCH(scatter_records)(boxes, begin, entries, count, place, records);
}

void sort_column(const ColumnRecord* records, std::size_t size, std::size_t axis, Column& column) {
  HWY_DYNAMIC_DISPATCH(sort_column)(records, size, axis, column);
}

std::size_t Column::memory() const {
  std::size_t bytes = bytes_of(index) + bytes_of(first) + bytes_of(cell) + bytes_of(last) + bytes_of(cell_end) +
                      bytes_of(front) + bytes_of(back);
  for (const auto& bound : bounds) bytes += bytes_of(bound);
  return bytes;
}

void copy_records(const Column& column, ColumnRecord* records) {
  for (std::size_t row = 0; row < column.size; ++row) {
    hwy::CopyBytes<16>(column.front.data() + 4 * row, records + row);
    hwy::CopyBytes<16>(column.back.data() + 4 * row, reinterpret_cast<float*>(records + row) + 4);
  }
}

namespace {

/// The positions of the set bits of a byte, ascending; zeros behind them.
constexpr auto places_of_bits = [] {
  std::array<std::array<std::uint8_t, 8>, 256> places{};
  for (std::size_t byte = 0; byte < 256; ++byte)
    for (std::uint8_t bit = 0, count = 0; bit < 8; ++bit)
      if ((byte >> bit & 1) != 0) places[byte][count++] = bit;
  return places;
}();

}  // namespace

// Writes all eight positions; the number of set bits tells where the next go. A loop over the bits would end by an
// unpredictable branch.
std::size_t pairs_of_hits(const RowHits* hits, std::size_t count, RowPair* out) {
  std::size_t found = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t row = hits[k].row;
    std::uint32_t begin = hits[k].begin;
    for (std::uint32_t bits = hits[k].bits; bits != 0; bits >>= 8, begin += 8) {
      const auto& places = places_of_bits[bits & 255];
      for (std::size_t bit = 0; bit < 8; ++bit) out[found + bit] = {row, begin + places[bit]};
      found += static_cast<std::size_t>(std::popcount(bits & 255));
    }
  }
  return found;
}

std::size_t boxes_in_slab(const BoxArray& boxes, std::size_t axis, float begin, float end, std::size_t most,
                          std::uint32_t* out) {
  return HWY_DYNAMIC_DISPATCH(boxes_in_slab)(boxes, axis, begin, end, most, out);
}

std::size_t overlap_column(const Column& column, std::size_t& row, RowHits* hits, std::size_t room) {
  return HWY_DYNAMIC_DISPATCH(overlap_column)(column, row, hits, room);
}
}  // namespace tandem
#endif
