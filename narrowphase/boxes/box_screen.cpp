// A quick separating axis test of several pairs of boxes, a pair a lane (vector kernel).
#include "boxes/box_screen.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

#include "boxes/box_axes.h"
#include "shapes/pair_order.h"
#include "tolerances.h"

#ifndef TANDEM_BOX_SCREEN_TABLE
#define TANDEM_BOX_SCREEN_TABLE
namespace tandem {
namespace {

/// For every byte the positions of its set bits, from the lowest on, then 0: four bits each.
constexpr std::array<std::uint32_t, 256> chosen_first = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t bits = 0; bits < 256; ++bits) {
    unsigned to = 0;
    for (std::uint32_t i = 0; i < 8; ++i)
      if ((bits >> i & 1u) != 0) table[bits] |= i << 4 * to++;
  }
  return table;
}();

}  // namespace
}  // namespace tandem
#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "boxes/box_screen.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

#if !HWY_HAVE_SCALABLE

static_assert(BoxPairList::most % lanes == 0 && BoxPairList::most <= 32 && lanes <= 8);

/// Some pairs of boxes, in the caller's order.
struct NearLanes {
  V a[12], b[12], half_a[4], half_b[4], shift[3];  // columns of the rotations, then the translations

  HWY_INLINE void set(const BoxPairList& pairs, std::size_t at) {
    static_assert(offsetof(Pose, translation) == 9 * sizeof(double));
    const auto nth = [&](std::size_t i) HWY_ATTR { return std::min(at + i, pairs.count - 1); };
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs.pose_a[nth(i)]->rotation.data(); }, a);
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs.pose_b[nth(i)]->rotation.data(); }, b);
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs.half_a[nth(i)]->data(); }, half_a);
    load_transposed([&](std::size_t i) HWY_ATTR { return pairs.half_b[nth(i)]->data(); }, half_b);
    for (int k = 0; k < 3; ++k) shift[k] = hn::Sub(b[9 + k], a[9 + k]);
  }
  HWY_INLINE M are_apart(double margin) const;
  HWY_INLINE M are_reversed(const BoxPairList& pairs, std::size_t at) const;
  HWY_INLINE void put(unsigned chosen, M reversed, BoxPairRows& rows, std::size_t column) const;
};

HWY_INLINE M NearLanes::are_apart(double margin) const {
  const D d;
  const auto sum = [](const V* u, const V* v)
                       HWY_ATTR { return hn::MulAdd(u[2], v[2], hn::MulAdd(u[1], v[1], hn::Mul(u[0], v[0]))); };
  // The error bound includes the size of the coordinates: far from the origin poses have lost digits.
  const V size =
      hn::Add(hn::Add(hn::Add(half_a[0], half_a[1]), half_a[2]), hn::Add(hn::Add(half_b[0], half_b[1]), half_b[2]));
  const V far = hn::Add(hn::Add(hn::Abs(shift[0]), hn::Abs(shift[1])), hn::Abs(shift[2]));
  const V enough = hn::MulAdd(number(tolerance::certain), hn::Add(size, far), number(margin));

  V r[3][3], q[3][3], t[3];
  for (int i = 0; i < 3; ++i) {
    t[i] = sum(a + 3 * i, shift);
    for (int j = 0; j < 3; ++j) {
      r[i][j] = sum(a + 3 * i, b + 3 * j);
      q[i][j] = hn::Abs(r[i][j]);
    }
  }
  V most = number(-1e300);
  for (int k = 0; k < 3; ++k) {
    most = hn::Max(most, hn::Sub(hn::Sub(hn::Abs(t[k]), half_a[k]), sum(half_b, q[k])));
    const V column[3] = {q[0][k], q[1][k], q[2][k]};
    most = hn::Max(most, hn::Sub(hn::Sub(hn::Abs(sum(b + 3 * k, shift)), half_b[k]), sum(half_a, column)));
  }
  M apart = hn::Gt(most, enough);
  if (hn::AllTrue(d, apart)) return apart;
  // The numerator is the separation times the length of a_i x b_j, which is at most 1: a sufficient numerator suffices.
  const V parallel = number(nearly_parallel);
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const V centre = hn::Abs(hn::NegMulAdd(t[i1], r[i2][j], hn::Mul(t[i2], r[i1][j])));
      const V reach =
          hn::MulAdd(half_a[i1], q[i2][j],
                     hn::MulAdd(half_a[i2], q[i1][j], hn::MulAdd(half_b[j1], q[i][j2], hn::Mul(half_b[j2], q[i][j1]))));
      apart = hn::Or(apart, hn::And(hn::Gt(hn::Sub(centre, reach), enough), hn::Le(q[i][j], parallel)));
    }
  }
  return apart;
}

// As boxes_reversed.
HWY_INLINE M NearLanes::are_reversed(const BoxPairList& pairs, std::size_t at) const {
  const D d;
  const V zero = hn::Zero(d);
  V key = hn::Add(hn::Add(hn::Mul(number(reversal[0]), shift[0]), hn::Mul(number(reversal[1]), shift[1])),
                  hn::Mul(number(reversal[2]), shift[2]));
  for (int k = 2; k >= 0; --k) {
    const V more = hn::Sub(half_b[k], half_a[k]);
    key = hn::IfThenElse(hn::Ne(more, zero), more, key);
  }
  if (!hn::AllFalse(d, hn::Eq(key, zero))) {
    HWY_ALIGN double keys[lanes];
    hn::Store(key, d, keys);
    for (std::size_t i = 0; i < std::min(lanes, pairs.count - at); ++i)
      if (keys[i] == 0 &&
          boxes_reversed(*pairs.half_a[at + i], *pairs.pose_a[at + i], *pairs.half_b[at + i], *pairs.pose_b[at + i]))
        keys[i] = -1;
    key = hn::Load(d, keys);
  }
  return hn::Lt(key, zero);
}

HWY_INLINE void NearLanes::put(unsigned chosen, M reversed, BoxPairRows& rows, std::size_t column) const {
  const D d;
  const hn::RebindToUnsigned<D> whole;
  // Not by Highway's Compress, for which gcc copies a table of 2 kB each time.
  const auto places = hn::Shr(hn::Set(whole, chosen_first[chosen]), hn::ShiftLeft<2>(hn::Iota(whole, 0)));
  const auto order = hn::IndicesFromVec(d, hn::And(places, hn::Set(whole, 7)));
  const auto put_row = [&](V x, double* row) HWY_ATTR { hn::StoreU(hn::TableLookupLanes(x, order), d, row + column); };
  HWY_UNROLL(12)
  for (int k = 0; k < 12; ++k) {
    put_row(hn::IfThenElse(reversed, b[k], a[k]), rows.pose_a[k]);
    put_row(hn::IfThenElse(reversed, a[k], b[k]), rows.pose_b[k]);
  }
  HWY_UNROLL(3)
  for (int k = 0; k < 3; ++k) {
    put_row(hn::IfThenElse(reversed, half_b[k], half_a[k]), rows.half_a[k]);
    put_row(hn::IfThenElse(reversed, half_a[k], half_b[k]), rows.half_b[k]);
  }
  put_row(hn::IfThenElse(reversed, number(-1), number(1)), rows.sense);
}

HWY_INLINE std::uint32_t screen(const BoxPairList& pairs, double margin, BoxPairRows* rows, std::size_t column) {
  const D d;
  std::uint32_t near = 0;
  for (std::size_t at = 0; at < pairs.count; at += lanes) {
    NearLanes x;
    x.set(pairs, at);
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, hn::AndNot(x.are_apart(margin), hn::FirstN(d, pairs.count - at)), bits);
    if (bits[0] == 0) continue;
    near |= std::uint32_t{bits[0]} << at;
    if (rows == nullptr) continue;
    x.put(bits[0], x.are_reversed(pairs, at), *rows, column);
    column += static_cast<std::size_t>(std::popcount(bits[0]));
  }
  return near;
}

// NOLINTBEGIN(misc-definitions-in-headers): included once a target
std::uint32_t screen_boxes(const BoxPairList& pairs, double margin) { return screen(pairs, margin, nullptr, 0); }
std::uint32_t take_near_boxes(const BoxPairList& pairs, double margin, BoxPairRows& rows, std::size_t column) {
  return screen(pairs, margin, &rows, column);
}
// NOLINTEND(misc-definitions-in-headers)

#else

// NOLINTBEGIN(misc-definitions-in-headers): included once a target
std::uint32_t screen_boxes(const BoxPairList& pairs, double) {
  return static_cast<std::uint32_t>((std::uint64_t{1} << pairs.count) - 1);
}
std::uint32_t take_near_boxes(const BoxPairList& pairs, double margin, BoxPairRows&, std::size_t) {
  return screen_boxes(pairs, margin);  // all are unknown, whatever their rows contain
}
// NOLINTEND(misc-definitions-in-headers)

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(screen_boxes);
HWY_EXPORT(take_near_boxes);

std::uint32_t screen_boxes(const BoxPairList& pairs, double margin) {
  return HWY_DYNAMIC_DISPATCH(screen_boxes)(pairs, margin);
}
std::uint32_t take_near_boxes(const BoxPairList& pairs, double margin, BoxPairRows& rows, std::size_t column) {
  return HWY_DYNAMIC_DISPATCH(take_near_boxes)(pairs, margin, rows, column);
}
}  // namespace tandem
#endif
