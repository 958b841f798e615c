// The support of one core, for the instruction set that the including file is compiled for.
#if defined(TANDEM_NARROWPHASE_CORE_POINT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef TANDEM_NARROWPHASE_CORE_POINT_INL_H
#undef TANDEM_NARROWPHASE_CORE_POINT_INL_H
#else
#define TANDEM_NARROWPHASE_CORE_POINT_INL_H
#endif

#include <hwy/highway.h>

#include "shapes/support.h"
#include "shapes/support_search-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
HWY_INLINE SupportPoint core_point(const ConvexView& v, const Vec3& d) {
  if (v.kind != ShapeKind::convex || v.vertices.size() <= 4) return core_support_point(v, d, nullptr);
  const std::uint32_t i = farthest_vertex(v.hull->support, v.vertices.data(), d[0], d[1], d[2]);
  return {v.vertices[i], i};
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
