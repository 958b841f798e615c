#include "box_screen.h"

#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "box_screen.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

using Four = hn::FixedTag<double, 4>;
using V = hn::Vec<Four>;

// Four numbers of each of four pairs become four vectors of one number each.
HWY_INLINE void load_transposed(const double* p0, const double* p1, const double* p2, const double* p3, V* out) {
  const Four d;
  const V v0 = hn::LoadU(d, p0), v1 = hn::LoadU(d, p1), v2 = hn::LoadU(d, p2), v3 = hn::LoadU(d, p3);
  const V low01 = hn::InterleaveLower(d, v0, v1), high01 = hn::InterleaveUpper(d, v0, v1);
  const V low23 = hn::InterleaveLower(d, v2, v3), high23 = hn::InterleaveUpper(d, v2, v3);
  out[0] = hn::ConcatLowerLower(d, low23, low01);
  out[1] = hn::ConcatLowerLower(d, high23, high01);
  out[2] = hn::ConcatUpperUpper(d, low23, low01);
  out[3] = hn::ConcatUpperUpper(d, high23, high01);
}

// Columns of the rotations one after the other, then the translations.
HWY_INLINE void load_poses(const Pose* p0, const Pose* p1, const Pose* p2, const Pose* p3, V* out) {
  static_assert(offsetof(Pose, translation) == 9 * sizeof(double));
  for (int k = 0; k < 12; k += 4)
    load_transposed(p0->rotation.data() + k, p1->rotation.data() + k, p2->rotation.data() + k, p3->rotation.data() + k,
                    out + k);
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
unsigned screen_boxes(const BoxPair* p, double margin) {
  const Four d;
  V a[12], b[12], half_a[4], half_b[4];
  load_poses(p[0].pose_a, p[1].pose_a, p[2].pose_a, p[3].pose_a, a);
  load_poses(p[0].pose_b, p[1].pose_b, p[2].pose_b, p[3].pose_b, b);
  load_transposed(p[0].half_a->data(), p[1].half_a->data(), p[2].half_a->data(), p[3].half_a->data(), half_a);
  load_transposed(p[0].half_b->data(), p[1].half_b->data(), p[2].half_b->data(), p[3].half_b->data(), half_b);
  const auto dot = [](const V* u, const V* v)
                       HWY_ATTR { return hn::MulAdd(u[2], v[2], hn::MulAdd(u[1], v[1], hn::Mul(u[0], v[0]))); };

  // A frame of its own for the distance: what the coordinates lose far out is in neither pose any more.
  const V shift[3] = {hn::Sub(b[9], a[9]), hn::Sub(b[10], a[10]), hn::Sub(b[11], a[11])};
  const V size =
      hn::Add(hn::Add(hn::Add(half_a[0], half_a[1]), half_a[2]), hn::Add(hn::Add(half_b[0], half_b[1]), half_b[2]));
  const V far = hn::Add(hn::Add(hn::Abs(shift[0]), hn::Abs(shift[1])), hn::Abs(shift[2]));
  const V enough = hn::MulAdd(hn::Set(d, 1e-12), hn::Add(size, far), hn::Set(d, margin));

  V r[3][3], q[3][3], t[3];
  for (int i = 0; i < 3; ++i) {
    t[i] = dot(a + 3 * i, shift);
    for (int j = 0; j < 3; ++j) {
      r[i][j] = dot(a + 3 * i, b + 3 * j);
      q[i][j] = hn::Abs(r[i][j]);
    }
  }
  V most = hn::Set(d, -1e300);
  for (int k = 0; k < 3; ++k) {
    most = hn::Max(most, hn::Sub(hn::Sub(hn::Abs(t[k]), half_a[k]), dot(half_b, q[k])));
    const V column[3] = {q[0][k], q[1][k], q[2][k]};
    most = hn::Max(most, hn::Sub(hn::Sub(hn::Abs(dot(b + 3 * k, shift)), half_b[k]), dot(half_a, column)));
  }
  auto apart = hn::Gt(most, enough);
  if (!hn::AllTrue(d, apart)) {
    // Along a_i x b_j, times its length: at most 1, so that what is enough with it is enough.
    const V parallel = hn::Set(d, nearly_parallel);
    for (int i = 0; i < 3; ++i) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
      for (int j = 0; j < 3; ++j) {
        const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
        const V centre = hn::Abs(hn::NegMulAdd(t[i1], r[i2][j], hn::Mul(t[i2], r[i1][j])));
        const V reach = hn::MulAdd(
            half_a[i1], q[i2][j],
            hn::MulAdd(half_a[i2], q[i1][j], hn::MulAdd(half_b[j1], q[i][j2], hn::Mul(half_b[j2], q[i][j1]))));
        apart = hn::Or(apart, hn::And(hn::Gt(hn::Sub(centre, reach), enough), hn::Le(q[i][j], parallel)));
      }
    }
  }
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(d, apart, bits);
  return bits[0];
}

#else

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
unsigned screen_boxes(const BoxPair*, double) { return 0; }

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(screen_boxes);

unsigned screen_boxes(const BoxPair* pairs, double margin) { return HWY_DYNAMIC_DISPATCH(screen_boxes)(pairs, margin); }
}  // namespace tandem
#endif
