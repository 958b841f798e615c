// Faces of a polytope that may be most aligned with a direction (vector kernel).
#include "manifold/faces_along.h"

#include <limits>

#include "tolerances.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "manifold/faces_along.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void faces_along(const FaceTable& faces, const float (&d)[3], FaceBits& bits) {
  const hn::CappedTag<float, 8> tag;
  const std::size_t lanes = hn::Lanes(tag), stride = faces.stride();
  const float *nx = faces.planes.data(), *ny = nx + stride, *nz = ny + stride;
  alignas(64) float along[FaceTable::most_faces];
  const auto x = hn::Set(tag, d[0]), y = hn::Set(tag, d[1]), z = hn::Set(tag, d[2]);
  auto most = hn::Set(tag, -std::numeric_limits<float>::max());
  // Entries behind the last face are 0, not above the maximum: some face of a polytope has a positive product.
  for (std::size_t i = 0; i < faces.faces; i += lanes) {
    const auto here = hn::Add(hn::Add(hn::Mul(x, hn::LoadU(tag, nx + i)), hn::Mul(y, hn::LoadU(tag, ny + i))),
                              hn::Mul(z, hn::LoadU(tag, nz + i)));
    hn::Store(here, tag, along + i);
    most = hn::Max(most, here);
  }
  constexpr auto cosine_rounding = static_cast<float>(tolerance::cosine_of_floats);
  const auto enough = hn::Sub(hn::MaxOfLanes(tag, most), hn::Set(tag, cosine_rounding));
  for (std::size_t i = 0; i < faces.faces; i += lanes) {
    std::uint8_t some[8] = {};
    const auto are_faces = hn::FirstN(tag, faces.faces - i);
    hn::StoreMaskBits(tag, hn::And(are_faces, hn::Ge(hn::Load(tag, along + i), enough)), some);
    bits[i / 64] |= std::uint64_t{some[0]} << i % 64;
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(faces_along);

FaceBits faces_along(const FaceTable& faces, const Vec3& d) {
  FaceBits bits{};
  const float rounded[3] = {static_cast<float>(d[0]), static_cast<float>(d[1]), static_cast<float>(d[2])};
  HWY_DYNAMIC_DISPATCH(faces_along)(faces, rounded, bits);
  return bits;
}
}  // namespace tandem
#endif
