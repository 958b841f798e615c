// Supports of the Minkowski difference A - B (vector kernel).
#include "shapes/minkowski_difference.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shapes/minkowski_difference.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/cpu_dispatch.h"

#include "shapes/core_point-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void minkowski(const MinkowskiDifference& d, const Vec3& n, MinkowskiPoint& out) {
  const Mat3& r = d.pose.rotation;
  const Vec3 back(-(r(0, 0) * n[0] + r(1, 0) * n[1] + r(2, 0) * n[2]),
                  -(r(0, 1) * n[0] + r(1, 1) * n[1] + r(2, 1) * n[2]),
                  -(r(0, 2) * n[0] + r(1, 2) * n[1] + r(2, 2) * n[2]));
  const SupportPoint pa = core_point(d.a, n), pb = core_point(d.b, back);
  for (int k = 0; k < 3; ++k) {
    out.a[k] = pa.p[k];
    out.w[k] = pa.p[k] - (r(k, 0) * pb.p[0] + r(k, 1) * pb.p[1] + r(k, 2) * pb.p[2] + d.pose.translation[k]);
  }
  out.vertex_a = pa.vertex;
  out.vertex_b = pb.vertex;
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(minkowski);

MinkowskiKernel minkowski_kernel() { return TANDEM_DISPATCH(minkowski); }
}  // namespace tandem
#endif
