// The heights of one polytope's vertices over the other's faces (vector kernel).
#include "convex/face_heights.h"

#include <limits>

#include "lanes/lanes_of_256_bits.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "convex/face_heights.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void face_heights(const FacePlanes& planes, const SmallVertices& other, const float (&turn)[9], const float (&shift)[3],
                  SmallVertices& placed, FaceHeights& out) {
  const hn::CappedTag<float, 8> tag;
  const hn::RebindToSigned<decltype(tag)> bits;
  const std::size_t lanes = hn::Lanes(tag);
  placed.count = other.count;
  for (std::size_t i = 0; i < other.count; i += lanes) {
    const auto x = hn::Load(tag, other.x + i), y = hn::Load(tag, other.y + i), z = hn::Load(tag, other.z + i);
    const auto row = [&](int k) HWY_ATTR {
      return hn::Add(hn::Add(hn::Mul(hn::Set(tag, turn[3 * k]), x), hn::Mul(hn::Set(tag, turn[3 * k + 1]), y)),
                     hn::Add(hn::Mul(hn::Set(tag, turn[3 * k + 2]), z), hn::Set(tag, shift[k])));
    };
    hn::Store(row(0), tag, placed.x + i);
    hn::Store(row(1), tag, placed.y + i);
    hn::Store(row(2), tag, placed.z + i);
  }
  // The last bits of a value hold the vertex's number, so the maximum brings it along.
  constexpr std::int32_t numbers = FaceTable::most_vertices - 1;
  static_assert((FaceTable::most_vertices & numbers) == 0);
  const auto value_bits = hn::BitCast(tag, hn::Set(bits, ~numbers));
  const float *nx = planes.planes, *ny = nx + planes.stride, *nz = ny + planes.stride, *offset = nz + planes.stride;
  const auto never = hn::Set(tag, std::numeric_limits<float>::max());
  auto least = never;
  for (std::size_t i = 0; i < planes.faces; i += 2 * lanes) {
    const auto x0 = hn::LoadU(tag, nx + i), y0 = hn::LoadU(tag, ny + i), z0 = hn::LoadU(tag, nz + i);
    const auto x1 = hn::LoadU(tag, nx + i + lanes), y1 = hn::LoadU(tag, ny + i + lanes),
               z1 = hn::LoadU(tag, nz + i + lanes);
    auto top0 = hn::Set(tag, -std::numeric_limits<float>::max()), top1 = top0;
    for (std::size_t j = 0; j < other.count; ++j) {
      const auto vx = hn::Set(tag, placed.x[j]), vy = hn::Set(tag, placed.y[j]), vz = hn::Set(tag, placed.z[j]);
      const auto number = hn::BitCast(tag, hn::Set(bits, static_cast<std::int32_t>(j)));
      const auto along0 = hn::Add(hn::Add(hn::Mul(x0, vx), hn::Mul(y0, vy)), hn::Mul(z0, vz));
      const auto along1 = hn::Add(hn::Add(hn::Mul(x1, vx), hn::Mul(y1, vy)), hn::Mul(z1, vz));
      top0 = hn::Max(top0, hn::Or(hn::And(along0, value_bits), number));
      top1 = hn::Max(top1, hn::Or(hn::And(along1, value_bits), number));
    }
    const auto unit = hn::Set(tag, planes.unit);
    const auto number_bits = hn::Set(bits, numbers);
    const auto at0 = hn::Add(hn::Mul(hn::LoadU(tag, offset + i), unit), top0);
    const auto at1 = hn::Add(hn::Mul(hn::LoadU(tag, offset + i + lanes), unit), top1);
    hn::Store(at0, tag, out.at + i);
    hn::Store(at1, tag, out.at + i + lanes);
    const std::size_t left = planes.faces - i;
    least = hn::Min(least, hn::IfThenElse(hn::FirstN(tag, left), at0, never));
    if (left > lanes) least = hn::Min(least, hn::IfThenElse(hn::FirstN(tag, left - lanes), at1, never));
    hn::Store(hn::And(hn::BitCast(bits, top0), number_bits), bits, out.vertex + i);
    hn::Store(hn::And(hn::BitCast(bits, top1), number_bits), bits, out.vertex + i + lanes);
  }
  out.least = hn::GetLane(hn::MinOfLanes(tag, least));
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(face_heights);
HeightKernel height_kernel() { return HWY_DYNAMIC_DISPATCH(face_heights); }
}  // namespace tandem
#endif
