// Loading triangles, a pair of them a lane. Included by kernels once for each target, within its namespace: no include
// guard.
#include "lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

HWY_INLINE void area_vector(const V (&t)[3][3], V* out) {
  V u[3], v[3];
  subtract(t[1], t[0], u);
  subtract(t[2], t[0], v);
  cross(u, v, out);
}

/// Loads both in A's frame. `pose`: of B in A's frame, as in TriangleTest.
HWY_INLINE void load_triangles(const TriangleRows& pairs, std::size_t at, const double* pose, V (&a)[3][3],
                               V (&b)[3][3]) {
  V frame[12];
  for (int k = 0; k < 12; ++k) frame[k] = number(pose[k]);
  for (int c = 0; c < 3; ++c) {
    V own[3];
    load(pairs.a[c], at, a[c]);
    load(pairs.b[c], at, own);
    place(frame, own, b[c]);
  }
}

HWY_INLINE std::uint32_t bits_of(M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(D(), mask, bytes);
  return bytes[0];
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
