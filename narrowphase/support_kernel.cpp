#include "support_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "support_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
HWY_INLINE std::uint32_t farthest_vertex(const SupportMap& map, const Vec3* vertices, double x, double y, double z) {
  const hn::CappedTag<float, 8> tag;
  const std::size_t lanes = hn::Lanes(tag);
  const SupportMap::Range range = map.candidates(x, y, z);
  const SupportMap::Block* const first = map.blocks() + range.first;
  double sx = x, sy = y, sz = z;
  const double longest = std::max({std::abs(x), std::abs(y), std::abs(z)});
  if (!(longest > 1e-25 && longest < 1e25)) {
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
      const double* const p = vertices[i].data();
      const double along = p[0] * x + p[1] * y + p[2] * z;
      if (along > most) most = along, best = i;
    }
  }
  return best;
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::uint32_t farthest(const SupportMap& map, const Vec3* vertices, const double* d) {
  return farthest_vertex(map, vertices, d[0], d[1], d[2]);
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void planes(std::size_t count, double sliver2, double x, double y, double z, PlaneBatch& batch) {
  const hn::CappedTag<double, 8> tag;
  const auto rx = hn::Set(tag, x), ry = hn::Set(tag, y), rz = hn::Set(tag, z), thin = hn::Set(tag, sliver2);
  const auto zero = hn::Zero(tag), infinity = hn::Set(tag, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < count; i += hn::Lanes(tag)) {
    const auto px = hn::Sub(hn::Load(tag, batch.from[0] + i), rx), py = hn::Sub(hn::Load(tag, batch.from[1] + i), ry),
               pz = hn::Sub(hn::Load(tag, batch.from[2] + i), rz), qx = hn::Sub(hn::Load(tag, batch.to[0] + i), rx),
               qy = hn::Sub(hn::Load(tag, batch.to[1] + i), ry), qz = hn::Sub(hn::Load(tag, batch.to[2] + i), rz);
    const auto dot = [](auto ax, auto ay, auto az, auto bx, auto by, auto bz)
                         HWY_ATTR { return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz)); };
    const auto nx = hn::Sub(hn::Mul(py, qz), hn::Mul(pz, qy)), ny = hn::Sub(hn::Mul(pz, qx), hn::Mul(px, qz)),
               nz = hn::Sub(hn::Mul(px, qy), hn::Mul(py, qx));
    const auto square = dot(nx, ny, nz, nx, ny, nz);
    const auto longest = hn::Max(dot(px, py, pz, px, py, pz), dot(qx, qy, qz, qx, qy, qz));
    const auto good = hn::Gt(square, hn::Mul(thin, longest));
    const auto length = hn::Sqrt(square);
    const auto ux = hn::IfThenElse(good, hn::Div(nx, length), zero),
               uy = hn::IfThenElse(good, hn::Div(ny, length), zero),
               uz = hn::IfThenElse(good, hn::Div(nz, length), zero);
    hn::Store(ux, tag, batch.normal[0] + i);
    hn::Store(uy, tag, batch.normal[1] + i);
    hn::Store(uz, tag, batch.normal[2] + i);
    hn::Store(hn::IfThenElse(good, dot(ux, uy, uz, rx, ry, rz), infinity), tag, batch.offset + i);
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(farthest);
HWY_EXPORT(planes);

SupportKernel support_kernel() { return HWY_DYNAMIC_DISPATCH(farthest); }
PlaneKernel plane_kernel() { return HWY_DYNAMIC_DISPATCH(planes); }
}  // namespace tandem
#endif
