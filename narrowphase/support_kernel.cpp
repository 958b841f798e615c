#include "support_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "support_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::uint32_t farthest(const double* xyz, const std::uint32_t* index, std::size_t blocks, const double* d) {
  const hn::CappedTag<double, 8> tag;
  const std::size_t lanes = hn::Lanes(tag);
  const auto dx = hn::Set(tag, d[0]), dy = hn::Set(tag, d[1]), dz = hn::Set(tag, d[2]);
  // Mul and Add, never fused: the same bits on every machine.
  const auto along = [&](const double* x) HWY_ATTR {
    return hn::Add(hn::Add(hn::Mul(hn::LoadU(tag, x), dx), hn::Mul(hn::LoadU(tag, x + 8), dy)),
                   hn::Mul(hn::LoadU(tag, x + 16), dz));
  };
  HWY_ALIGN double value[8];
  std::size_t best_block = 0;
  double best = 0;
  // Block by block: the maximum of the eight, and only where it grows which one it is.
  for (std::size_t b = 0; b < blocks; ++b, xyz += 24) {
    auto most = along(xyz);
    hn::Store(most, tag, value);
    for (std::size_t l = lanes; l < 8; l += lanes) {
      const auto s = along(xyz + l);
      hn::Store(s, tag, value + l);
      most = hn::Max(most, s);
    }
    const double m = hn::GetLane(hn::MaxOfLanes(tag, most));
    if (b == 0 || m > best) {
      best = m;
      const auto wanted = hn::Set(tag, m);
      for (std::size_t l = 0; l < 8; l += lanes) {
        const auto found = hn::FindFirstTrue(tag, hn::Eq(hn::Load(tag, value + l), wanted));
        if (found >= 0) {
          best_block = 8 * b + l + static_cast<std::size_t>(found);
          break;
        }
      }
    }
  }
  return index[best_block];
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(farthest);

SupportKernel support_kernel() { return HWY_DYNAMIC_DISPATCH(farthest); }
}  // namespace tandem
#endif
