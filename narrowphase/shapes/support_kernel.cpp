// Vector kernels of support functions, compiled once for each instruction set.
#include "shapes/support_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "shapes/hull.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shapes/support_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/cpu_dispatch.h"
#include "shapes/support_search-inl.h"
#include "tolerances.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::uint32_t farthest(const SupportMap& map, const Vec3* vertices, const double* d) {
  return farthest_vertex(map, vertices, d[0], d[1], d[2]);
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::uint32_t most_along(const Hull& hull, const double* d) {
  const auto normal = [&hull](std::uint32_t i) -> const Vec3& { return hull.faces[i].normal; };
  return farthest_point(hull.normals, normal, d[0], d[1], d[2]);
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
double reach(const SupportMap& map, const double* d) {
  const hn::CappedTag<float, 8> tag;
  const double longest = std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
  if (!(longest > tolerance::shortest_in_floats && longest < 1e25)) return std::numeric_limits<double>::infinity();
  const SupportMap::Range range = map.candidates(d[0], d[1], d[2]);
  const SupportMap::Block* const b = map.blocks() + range.first;
  const float fx = static_cast<float>(d[0]), fy = static_cast<float>(d[1]), fz = static_cast<float>(d[2]);
  const std::array<float, 3>& s = map.slack();
  const float slack = std::abs(fx) * s[0] + std::abs(fy) * s[1] + std::abs(fz) * s[2];
  const auto dx = hn::Set(tag, fx), dy = hn::Set(tag, fy), dz = hn::Set(tag, fz);
  auto top = hn::Set(tag, -std::numeric_limits<float>::max());
  for (std::size_t i = 0; i < range.blocks; ++i)
    for (std::size_t l = 0; l < 8; l += hn::Lanes(tag))
      top =
          hn::Max(top, hn::Add(hn::Add(hn::Mul(hn::Load(tag, b[i].x + l), dx), hn::Mul(hn::Load(tag, b[i].y + l), dy)),
                               hn::Mul(hn::Load(tag, b[i].z + l), dz)));
  return map.unit() * (static_cast<double>(hn::GetLane(hn::MaxOfLanes(tag, top))) + static_cast<double>(slack));
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
std::size_t least(const double* values, std::size_t count, double limit) {
  const hn::CappedTag<double, 4> tag;
  const std::size_t lanes = hn::Lanes(tag);
  auto low = hn::Set(tag, limit), low2 = low;
  const std::size_t whole = count / 8 * 8;
  for (std::size_t i = 0; i < whole; i += 8)
    for (std::size_t l = 0; l < 8; l += 2 * lanes) {
      low = hn::Min(low, hn::LoadU(tag, values + i + l));
      low2 = hn::Min(low2, hn::LoadU(tag, values + i + l + lanes));
    }
  double found = hn::GetLane(hn::MinOfLanes(tag, hn::Min(low, low2)));
  for (std::size_t i = whole; i < count; ++i) found = std::min(found, values[i]);
  if (!(found < limit)) return count;
  const auto sought = hn::Set(tag, found);
  for (std::size_t i = 0; i < whole; i += lanes) {
    const auto equal = hn::Eq(hn::LoadU(tag, values + i), sought);
    if (!hn::AllFalse(tag, equal)) return i + static_cast<std::size_t>(hn::FindFirstTrue(tag, equal));
  }
  for (std::size_t i = whole;; ++i)
    if (values[i] == found) return i;
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void planes(std::size_t count, double sliver2, double x, double y, double z, PlaneBatch& batch) {
  const hn::CappedTag<double, 8> tag;
  const auto rx = hn::Set(tag, x), ry = hn::Set(tag, y), rz = hn::Set(tag, z), thin = hn::Set(tag, sliver2);
  const auto zero = hn::Zero(tag), infinity = hn::Set(tag, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < count; i += hn::Lanes(tag)) {
    const auto at = [&](int k, std::size_t l) HWY_ATTR { return hn::LoadU(tag, batch.loop[k] + l); };
    const auto px = hn::Sub(at(0, i), rx), py = hn::Sub(at(1, i), ry), pz = hn::Sub(at(2, i), rz),
               qx = hn::Sub(at(0, i + 1), rx), qy = hn::Sub(at(1, i + 1), ry), qz = hn::Sub(at(2, i + 1), rz);
    const auto dot = [](auto ax, auto ay, auto az, auto bx, auto by, auto bz)
                         HWY_ATTR { return hn::Add(hn::Add(hn::Mul(ax, bx), hn::Mul(ay, by)), hn::Mul(az, bz)); };
    const auto nx = hn::Sub(hn::Mul(py, qz), hn::Mul(pz, qy)), ny = hn::Sub(hn::Mul(pz, qx), hn::Mul(px, qz)),
               nz = hn::Sub(hn::Mul(px, qy), hn::Mul(py, qx));
    const auto square = dot(nx, ny, nz, nx, ny, nz);
    const auto longest = hn::Max(dot(px, py, pz, px, py, pz), dot(qx, qy, qz, qx, qy, qz));
    const auto good = hn::Gt(square, hn::Mul(thin, longest));
    const auto length = hn::Sqrt(square);
    const auto ux = hn::IfThenElse(good, hn::Div(nx, length), zero),
               uy = hn::IfThenElse(good, hn::Div(ny, length), zero),
               uz = hn::IfThenElse(good, hn::Div(nz, length), zero);
    hn::Store(ux, tag, batch.normal[0] + i);
    hn::Store(uy, tag, batch.normal[1] + i);
    hn::Store(uz, tag, batch.normal[2] + i);
    hn::Store(hn::IfThenElse(good, dot(ux, uy, uz, rx, ry, rz), infinity), tag, batch.offset + i);
  }
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(farthest);
HWY_EXPORT(most_along);
HWY_EXPORT(planes);
HWY_EXPORT(reach);
HWY_EXPORT(least);

SupportKernel support_kernel() { return TANDEM_DISPATCH(farthest); }
FaceKernel face_kernel() { return TANDEM_DISPATCH(most_along); }
ReachKernel reach_kernel() { return TANDEM_DISPATCH(reach); }
LeastKernel least_kernel() { return TANDEM_DISPATCH(least); }
PlaneKernel plane_kernel() { return TANDEM_DISPATCH(planes); }
}  // namespace tandem
#endif
