#include "support_kernel.h"

#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "support_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::uint32_t farthest(const double* xyz, const std::uint32_t* index, std::size_t blocks, double x, double y,
                       double z) {
  const hn::CappedTag<double, 8> tag;
  const std::size_t lanes = hn::Lanes(tag);
  const auto dx = hn::Set(tag, x), dy = hn::Set(tag, y), dz = hn::Set(tag, z);
  // Mul and Add, never fused: the same bits on every machine.
  const auto along = [&](const double* p) HWY_ATTR {
    return hn::Add(hn::Add(hn::Mul(hn::LoadU(tag, p), dx), hn::Mul(hn::LoadU(tag, p + 8), dy)),
                   hn::Mul(hn::LoadU(tag, p + 16), dz));
  };
  HWY_ALIGN double value[8], in_block[8];
  auto most = along(xyz);
  if (blocks == 1) {
    hn::Store(most, tag, value);
    for (std::size_t l = lanes; l < 8; l += lanes) {
      const auto s = along(xyz + l);
      hn::Store(s, tag, value + l);
      most = hn::Max(most, s);
    }
  } else {
    // The first of the blocks that is best in each of the eight places, then the best of the eight.
    for (std::size_t l = 0; l < 8; l += lanes) {
      auto best = along(xyz + l);
      auto number = hn::Zero(tag);
      for (std::size_t b = 1; b < blocks; ++b) {
        const auto s = along(xyz + 24 * b + l);
        const auto more = hn::Gt(s, best);
        best = hn::IfThenElse(more, s, best);
        number = hn::IfThenElse(more, hn::Set(tag, static_cast<double>(b)), number);
      }
      hn::Store(best, tag, value + l);
      hn::Store(number, tag, in_block + l);
      most = hn::Max(most, best);
    }
  }
  most = hn::MaxOfLanes(tag, most);
  unsigned places = 0;
  for (std::size_t l = 0; l < 8; l += lanes) {
    std::uint8_t bits[8];
    hn::StoreMaskBits(tag, hn::Eq(hn::Load(tag, value + l), most), bits);
    places |= static_cast<unsigned>(bits[0]) << l;
  }
  if (places == 0) return index[0];  // not a number
  std::size_t best = hwy::Num0BitsBelowLS1Bit_Nonzero32(places);
  if (blocks == 1) return index[best];
  best += 8 * static_cast<std::size_t>(in_block[best]);
  for (places &= places - 1; places != 0; places &= places - 1) {
    const std::size_t place = hwy::Num0BitsBelowLS1Bit_Nonzero32(places);
    best = std::min(best, 8 * static_cast<std::size_t>(in_block[place]) + place);
  }
  return index[best];
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
