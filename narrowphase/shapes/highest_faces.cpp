// The faces of a small polytope that may be the highest over a point, or the most aligned with a direction (vector
// kernel).
#include "shapes/highest_faces.h"

#include <limits>

#include "tolerances.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shapes/highest_faces.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The faces whose height normal . (p[0], p[1], p[2]) - offset * p[3] is within `slack` of the greatest.
// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void highest_faces(const FaceTable& faces, const float (&p)[4], float slack, FaceBits& bits) {
  const hn::CappedTag<float, 8> tag;
  const std::size_t lanes = hn::Lanes(tag), stride = faces.stride();
  const float *nx = faces.planes.data(), *ny = nx + stride, *nz = ny + stride, *offset = nz + stride;
  alignas(64) float height[FaceTable::most_faces];
  const auto x = hn::Set(tag, p[0]), y = hn::Set(tag, p[1]), z = hn::Set(tag, p[2]), w = hn::Set(tag, p[3]);
  auto most = hn::Set(tag, -std::numeric_limits<float>::max());
  // Padding is not above the maximum: its product with a direction is 0, and some face of a polytope has a positive
  // one; its height over a point is -`beyond`.
  for (std::size_t i = 0; i < faces.faces; i += lanes) {
    const auto along = hn::Add(hn::Add(hn::Mul(x, hn::LoadU(tag, nx + i)), hn::Mul(y, hn::LoadU(tag, ny + i))),
                               hn::Mul(z, hn::LoadU(tag, nz + i)));
    const auto here = hn::Sub(along, hn::Mul(w, hn::LoadU(tag, offset + i)));
    hn::Store(here, tag, height + i);
    most = hn::Max(most, here);
  }
  const auto enough = hn::Sub(hn::MaxOfLanes(tag, most), hn::Set(tag, slack));
  for (std::size_t i = 0; i < faces.faces; i += lanes) {
    std::uint8_t some[8] = {};
    hn::StoreMaskBits(tag, hn::Ge(hn::Load(tag, height + i), enough), some);
    bits[i / 64] |= std::uint64_t{some[0]} << i % 64;
  }
  if (faces.faces % 64 != 0) bits[faces.faces / 64] &= (std::uint64_t{1} << faces.faces % 64) - 1;
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(highest_faces);

FaceBits faces_along(const FaceTable& faces, const Vec3& d) {
  FaceBits bits{};
  const float rounded[4] = {static_cast<float>(d[0]), static_cast<float>(d[1]), static_cast<float>(d[2]), 0};
  HWY_DYNAMIC_DISPATCH(highest_faces)(faces, rounded, static_cast<float>(tolerance::cosine_of_floats), bits);
  return bits;
}

FaceBits faces_over(const Hull& hull, const Vec3& p) {
  FaceBits bits{};
  const double per_unit = 1 / hull.support.unit();  // exact: a power of two
  const Vec3 q = (p - hull.inside) * per_unit;
  constexpr double farthest_vertex = 0.5 * FaceTable::beyond;
  const double in_doubles = tolerance::support_of_doubles * (p.lpNorm<1>() + hull.inside.lpNorm<1>()) * per_unit;
  const double slack = 2 * (tolerance::support_of_floats * (q.lpNorm<1>() + farthest_vertex) + in_doubles);
  if (!(slack < 1)) {  // so far away that floats tell no faces apart, and may not hold q
    for (std::size_t i = 0; i < hull.faces.size(); ++i) bits[i / 64] |= std::uint64_t{1} << i % 64;
    return bits;
  }
  const float rounded[4] = {static_cast<float>(q[0]), static_cast<float>(q[1]), static_cast<float>(q[2]), 1};
  HWY_DYNAMIC_DISPATCH(highest_faces)(hull.face_table, rounded, static_cast<float>(slack), bits);
  return bits;
}

}  // namespace tandem
#endif
