// The separations of two boxes along the 15 axes of the separating axis test, in scalars and in vectors.
#include "boxes/box_axes.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "boxes/box_axes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/cpu_dispatch.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Products are summed in one order in both versions, that of Eigen's scalar code and of the kernels for several pairs,
// and never fused: the same bits on every machine.
constexpr double never = -1e300;  // less than any separation

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

using Four = hn::FixedTag<double, 4>;

// Rows 0 to 2 of the matrix with these columns, whose fourth numbers are dropped; the rows' are 0.
HWY_INLINE void transpose(hn::Vec<Four> c0, hn::Vec<Four> c1, hn::Vec<Four> c2, hn::Vec<Four>* row) {
  const Four d;
  const auto zero = hn::Zero(d);
  const auto low01 = hn::InterleaveLower(d, c0, c1), high01 = hn::InterleaveUpper(d, c0, c1);
  const auto low2 = hn::InterleaveLower(d, c2, zero), high2 = hn::InterleaveUpper(d, c2, zero);
  row[0] = hn::ConcatLowerLower(d, low2, low01);
  row[1] = hn::ConcatLowerLower(d, high2, high01);
  row[2] = hn::ConcatUpperUpper(d, low2, low01);
}

using V = hn::Vec<Four>;

HWY_INLINE V of(const double* p, int k) { return hn::Set(Four(), p[k]); }

HWY_INLINE unsigned bits(hn::Mask<Four> mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(Four(), mask, bytes);
  return static_cast<unsigned>(bytes[0]);
}

// The numerators of the separations along the edge axes, three a vector, and which of these axes may be the best. `r`:
// the dot products of the boxes' axes.
HWY_INLINE void measure_edges(const double* half_a, const double* half_b, const V* r, V most_face, BoxAxes* x) {
  const Four d;
  const V b = hn::LoadU(d, half_b);
  const auto used = hn::FirstN(d, 3);
  alignas(32) static constexpr std::int64_t forward[4] = {1, 2, 0, 3}, back[4] = {2, 0, 1, 3};
  const auto next = hn::SetTableIndices(d, forward), last = hn::SetTableIndices(d, back);
  const V b_next = hn::TableLookupLanes(b, next), b_last = hn::TableLookupLanes(b, last);
  // The numerator is the separation times a length <= 1, so a numerator below the faces' separation cannot win, and
  // most are.
  const V hopeless = hn::Min(most_face, hn::Zero(d)), parallel = hn::Set(d, nearly_parallel);
  V q[3], edge[3];
  for (int i = 0; i < 3; ++i) q[i] = hn::Abs(r[i]);
  unsigned hopeful = 0;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    const V centre = hn::Abs(hn::Sub(hn::Mul(of(x->t, i2), r[i1]), hn::Mul(of(x->t, i1), r[i2])));
    const V from_a = hn::Add(hn::Mul(of(half_a, i1), q[i2]), hn::Mul(of(half_a, i2), q[i1]));
    const V from_b =
        hn::Add(hn::Mul(b_next, hn::TableLookupLanes(q[i], last)), hn::Mul(b_last, hn::TableLookupLanes(q[i], next)));
    edge[i] = hn::Sub(hn::Sub(centre, from_a), from_b);
    hn::Store(q[i], d, x->q[i]);
    hn::Store(edge[i], d, x->edge[i]);
    hopeful |= bits(hn::And(used, hn::Or(hn::Gt(edge[i], hopeless), hn::Gt(q[i], parallel)))) << (3 * i);
  }
  x->hopeful = hopeful;
  const V most = hn::IfThenElse(used, hn::Max(hn::Max(edge[0], edge[1]), edge[2]), hn::Set(d, never));
  x->most_edge = hn::GetLane(hn::MaxOfLanes(d, most));
  x->most_cosine = hn::GetLane(hn::MaxOfLanes(d, hn::Max(hn::Max(q[0], q[1]), q[2])));
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
bool measure_axes(const double* half_a, const Pose* pose_a, const double* half_b, const Pose* pose_b, double beyond,
                  BoxAxes* x) {
  const Four d;
  // The load of the third column includes the first coordinate of the translation.
  static_assert(offsetof(Pose, translation) == 9 * sizeof(double));
  const double *ma = pose_a->rotation.data(), *mb = pose_b->rotation.data();
  V row_a[3], row_b[3], r[3], q[3], q_column[3];
  transpose(hn::LoadU(d, ma), hn::LoadU(d, ma + 3), hn::LoadU(d, ma + 6), row_a);
  transpose(hn::LoadU(d, mb), hn::LoadU(d, mb + 3), hn::LoadU(d, mb + 6), row_b);
  const auto sum_of_products = [](V p0, V p1, V p2, const V* v) HWY_ATTR {
    return hn::Add(hn::Mul(p0, v[0]), hn::Add(hn::Mul(p1, v[1]), hn::Mul(p2, v[2])));
  };
  const V d0 = hn::Set(d, pose_b->translation[0] - pose_a->translation[0]);
  const V d1 = hn::Set(d, pose_b->translation[1] - pose_a->translation[1]);
  const V d2 = hn::Set(d, pose_b->translation[2] - pose_a->translation[2]);
  const V t = sum_of_products(d0, d1, d2, row_a), u = sum_of_products(d0, d1, d2, row_b);
  for (int i = 0; i < 3; ++i) {
    r[i] = sum_of_products(of(ma, 3 * i), of(ma, 3 * i + 1), of(ma, 3 * i + 2), row_b);
    q[i] = hn::Abs(r[i]);
  }
  transpose(q[0], q[1], q[2], q_column);
  const V a = hn::LoadU(d, half_a), b = hn::LoadU(d, half_b);
  const V face_of_a =
      hn::Sub(hn::Sub(hn::Abs(t), a), sum_of_products(of(half_b, 0), of(half_b, 1), of(half_b, 2), q_column));
  const V face_of_b = hn::Sub(hn::Sub(hn::Abs(u), b), sum_of_products(of(half_a, 0), of(half_a, 1), of(half_a, 2), q));
  const V best_face = hn::IfThenElse(hn::FirstN(d, 3), hn::Max(face_of_a, face_of_b), hn::Set(d, never));
  const V most_face = hn::MaxOfLanes(d, best_face);
  if (!hn::AllFalse(d, hn::Gt(best_face, hn::Set(d, beyond)))) {
    x->most_face = hn::GetLane(most_face);
    x->parting = bits(hn::Eq(face_of_a, most_face)) | bits(hn::Eq(face_of_b, most_face)) << 4;
    x->against = bits(hn::Lt(t, hn::Zero(d))) | bits(hn::Lt(u, hn::Zero(d))) << 4;
    return true;
  }
  hn::Store(a, d, x->a);
  hn::Store(b, d, x->b);
  hn::Store(t, d, x->t);
  hn::Store(u, d, x->u);
  hn::Store(face_of_a, d, x->face_of_a);
  hn::Store(face_of_b, d, x->face_of_b);
  for (int i = 0; i < 3; ++i) hn::Store(r[i], d, x->r[i]);
  measure_edges(half_a, half_b, r, most_face, x);
  return false;
}

#else

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
bool measure_axes(const double* half_a, const Pose* pose_a, const double* half_b, const Pose* pose_b, double beyond,
                  BoxAxes* x) {
  const double *ma = pose_a->rotation.data(), *mb = pose_b->rotation.data();
  double shift[3];
  for (int k = 0; k < 3; ++k) shift[k] = pose_b->translation[k] - pose_a->translation[k];
  const auto dot = [](double p0, double p1, double p2, const double* v) { return p0 * v[0] + (p1 * v[1] + p2 * v[2]); };
  for (int i = 0; i < 3; ++i) {
    x->a[i] = half_a[i];
    x->b[i] = half_b[i];
    x->t[i] = dot(shift[0], shift[1], shift[2], ma + 3 * i);
    x->u[i] = dot(shift[0], shift[1], shift[2], mb + 3 * i);
    for (int j = 0; j < 3; ++j) {
      x->r[i][j] = dot(ma[3 * i], ma[3 * i + 1], ma[3 * i + 2], mb + 3 * j);
      x->q[i][j] = std::abs(x->r[i][j]);
    }
  }
  x->most_face = never;
  for (int k = 0; k < 3; ++k) {
    x->face_of_a[k] = std::abs(x->t[k]) - half_a[k] - dot(half_b[0], half_b[1], half_b[2], x->q[k]);
    x->face_of_b[k] =
        std::abs(x->u[k]) - half_b[k] - (half_a[0] * x->q[0][k] + (half_a[1] * x->q[1][k] + half_a[2] * x->q[2][k]));
    x->most_face = std::max({x->most_face, x->face_of_a[k], x->face_of_b[k]});
  }
  if (x->most_face > beyond) {
    x->parting = x->against = 0;
    for (unsigned k = 0; k < 3; ++k) {
      x->parting |= (x->face_of_a[k] == x->most_face ? 1u : 0u) << k | (x->face_of_b[k] == x->most_face ? 16u : 0u)
                                                                           << k;
      x->against |= (x->t[k] < 0 ? 1u : 0u) << k | (x->u[k] < 0 ? 16u : 0u) << k;
    }
    return true;
  }
  const double hopeless = std::min(x->most_face, 0.0);
  x->hopeful = 0;
  x->most_edge = never;
  x->most_cosine = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double centre = std::abs(x->t[i2] * x->r[i1][j] - x->t[i1] * x->r[i2][j]);
      const double from_a = half_a[i1] * x->q[i2][j] + half_a[i2] * x->q[i1][j];
      const double from_b = half_b[j1] * x->q[i][j2] + half_b[j2] * x->q[i][j1];
      x->edge[i][j] = centre - from_a - from_b;
      x->most_edge = std::max(x->most_edge, x->edge[i][j]);
      x->most_cosine = std::max(x->most_cosine, x->q[i][j]);
      if (x->edge[i][j] > hopeless || x->q[i][j] > nearly_parallel) x->hopeful |= 1u << (3 * i + j);
    }
  return false;
}

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(measure_axes);

bool measure_axes(const double* half_a, const Pose* pose_a, const double* half_b, const Pose* pose_b, double beyond,
                  BoxAxes* axes) {
  return TANDEM_DISPATCH(measure_axes)(half_a, pose_a, half_b, pose_b, beyond, axes);
}
}  // namespace tandem
#endif
