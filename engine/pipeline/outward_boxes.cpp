// Rounds boxes outward to floats, several at once (vector kernel).
#include "pipeline/outward_boxes.h"

#include <limits>

// With vectors of 512 bits the spheres of a scene, which use none, take 1.07 of the time: see
// docs/notes/narrowphase.md.
#undef HWY_DISABLED_TARGETS
#define HWY_DISABLED_TARGETS ((HWY_AVX2 - 1) | TANDEM_DISABLED_TARGETS)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "pipeline/outward_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void round_outward(const BoundsRows* bounds, double grow, FloatRows* out) {
  const hn::ScalableTag<double> d;
  const hn::Rebind<float, decltype(d)> f;
  const hn::Rebind<std::int32_t, decltype(d)> i;
  constexpr double largest = std::numeric_limits<float>::max();
  const auto most = hn::Set(d, largest), least = hn::Set(d, -largest), more = hn::Set(d, grow);
  const auto up = [&](auto x) {
    x = hn::Min(hn::Max(x, least), most);
    const auto nearest = hn::DemoteTo(f, x);
    const auto is_below = hn::Lt(hn::PromoteTo(d, nearest), x);
    const auto below = hn::Gt(hn::DemoteTo(f, hn::IfThenElseZero(is_below, hn::Set(d, 1.0))), hn::Zero(f));
    // The next float above, by its bits: away from 0 or towards it; from either 0 the smallest positive float.
    const auto bits = hn::IfThenZeroElse(hn::Eq(nearest, hn::Zero(f)), nearest);
    const auto step = hn::Or(hn::BroadcastSignBit(hn::BitCast(i, bits)), hn::Set(i, 1));
    return hn::IfThenElse(below, hn::BitCast(f, hn::Add(hn::BitCast(i, bits), step)), nearest);
  };
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t k = 0; k < BoundsRows::bodies; k += hn::Lanes(d)) {
      const auto lo = hn::Sub(hn::Load(d, bounds->lo[axis] + k), more);
      const auto hi = hn::Add(hn::Load(d, bounds->hi[axis] + k), more);
      hn::Store(hn::Neg(up(hn::Neg(lo))), f, out->lo[axis] + k);
      hn::Store(up(hi), f, out->hi[axis] + k);
    }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(round_outward);

void round_outward(const BoundsRows& bounds, double grow, FloatRows& out) {
  HWY_DYNAMIC_DISPATCH(round_outward)(&bounds, grow, &out);
}
}  // namespace tandem
#endif
