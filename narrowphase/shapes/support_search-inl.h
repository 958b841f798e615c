// Supports of polytopes, for the instruction set that the including file is compiled for.
#if defined(TANDEM_NARROWPHASE_SUPPORT_SEARCH_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TANDEM_NARROWPHASE_SUPPORT_SEARCH_INL_H
#undef TANDEM_NARROWPHASE_SUPPORT_SEARCH_INL_H
#else
#define TANDEM_NARROWPHASE_SUPPORT_SEARCH_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "shapes/support_map.h"
#include "tolerances.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Searches among the points that the map was made of; `place` of a number returns the point.
template <class Place>
HWY_INLINE std::uint32_t farthest_point(const SupportMap& map, const Place& place, double x, double y, double z) {
  const hn::CappedTag<float, 8> tag;
  const std::size_t lanes = hn::Lanes(tag);
  const SupportMap::Range range = map.candidates(x, y, z);
  const SupportMap::Block* const first = map.blocks() + range.first;
  double sx = x, sy = y, sz = z;
  const double longest = std::max({std::abs(x), std::abs(y), std::abs(z)});
  if (!(longest > tolerance::shortest_in_floats && longest < 1e25)) {
    const int e = longest > 0 && longest < std::numeric_limits<double>::infinity() ? -std::ilogb(longest) : 0;
    sx = std::ldexp(x, e), sy = std::ldexp(y, e), sz = std::ldexp(z, e);
  }
  const float fx = static_cast<float>(sx), fy = static_cast<float>(sy), fz = static_cast<float>(sz);
  const std::array<float, 3>& s = map.slack();
  const float slack = std::abs(fx) * s[0] + std::abs(fy) * s[1] + std::abs(fz) * s[2];
  const auto dx = hn::Set(tag, fx), dy = hn::Set(tag, fy), dz = hn::Set(tag, fz);

  constexpr std::size_t part = SupportMap::searched_all;
  std::uint32_t best = first[0].index[0];
  double most = -std::numeric_limits<double>::infinity();
  for (std::size_t from = 0; from < range.blocks; from += part) {
    const SupportMap::Block* const b = first + from;
    const std::size_t blocks = std::min<std::size_t>(part, range.blocks - from);
    HWY_ALIGN float value[8 * part];
    auto top = hn::Set(tag, -std::numeric_limits<float>::max());
    for (std::size_t i = 0; i < blocks; ++i)
      for (std::size_t l = 0; l < 8; l += lanes) {
        const auto along =
            hn::Add(hn::Add(hn::Mul(hn::Load(tag, b[i].x + l), dx), hn::Mul(hn::Load(tag, b[i].y + l), dy)),
                    hn::Mul(hn::Load(tag, b[i].z + l), dz));
        hn::Store(along, tag, value + 8 * i + l);
        top = hn::Max(top, along);
      }
    const auto threshold = hn::Sub(hn::MaxOfLanes(tag, top), hn::Set(tag, slack));
    std::uint64_t near = 0;
    for (std::size_t i = 0; i < blocks; ++i)
      for (std::size_t l = 0; l < 8; l += lanes) {
        std::uint8_t bits[8];
        hn::StoreMaskBits(tag, hn::Ge(hn::Load(tag, value + 8 * i + l), threshold), bits);
        near |= std::uint64_t{bits[0]} << (8 * i + l);
      }
    if (range.blocks <= part && (near & (near - 1)) == 0 && near != 0) {
      const std::size_t only = hwy::Num0BitsBelowLS1Bit_Nonzero64(near);
      return b[only / 8].index[only % 8];
    }
    for (; near != 0; near &= near - 1) {
      const std::size_t at = hwy::Num0BitsBelowLS1Bit_Nonzero64(near);
      const std::uint32_t i = b[at / 8].index[at % 8];
      const double* const p = place(i).data();
      const double along = p[0] * x + p[1] * y + p[2] * z;
      if (along > most) most = along, best = i;
    }
  }
  return best;
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
HWY_INLINE std::uint32_t farthest_vertex(const SupportMap& map, const Vec3* vertices, double x, double y, double z) {
  const auto place = [vertices](std::uint32_t i) -> const Vec3& { return vertices[i]; };
  return farthest_point(map, place, x, y, z);
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
