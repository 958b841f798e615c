#include "queries/link_boxes.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <array>
#include <limits>

#include "scene/tolerances.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "queries/link_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t poses_a_copy = 64;  // a multiple of all vectors' lengths

// Numbers of poses, one array each; the last pose is repeated up to a vector's end. Not by gathers, which some
// processors have been made slow at, nor a vector at a time: what was just stored in pieces cannot be loaded at once.
void copy_numbers(const Pose* pose, std::size_t stride, std::size_t count, const Pose* next,
                  double (*rows)[poses_a_copy]) {
  for (std::size_t k = 0; k < count; ++k, pose += stride) {
    if (next != nullptr) {
      hwy::Prefetch(next + k);
      hwy::Prefetch(next[k].translation.data());
    }
    for (std::size_t n = 0; n < 9; ++n) rows[n][k] = pose->rotation.data()[n];  // column by column
    for (std::size_t n = 0; n < 3; ++n) rows[9 + n][k] = pose->translation.data()[n];
  }
  for (std::size_t k = count; k % (HWY_MAX_BYTES / sizeof(double)) != 0; ++k)
    for (std::size_t n = 0; n < 12; ++n) rows[n][k] = rows[n][count - 1];
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
bool link_boxes(const LinkBox* link, const Pose* first, std::size_t stride, std::size_t count, BoxArray* boxes,
                std::size_t at, const Pose* next, Aabb* all) {
  const hn::ScalableTag<double> d;
  const hn::Rebind<float, decltype(d)> f;
  const std::size_t lanes = hn::Lanes(d);
  const auto radius = hn::Set(d, link->radius), one = hn::Set(d, 1.0);
  const auto skew = hn::Set(d, tolerance::skew_of_links), far = hn::Set(d, 1e30);
  const auto largest = hn::Set(d, double{std::numeric_limits<float>::max()});
  const auto last_bit = hn::Set(d, double{std::numeric_limits<float>::epsilon()});
  const auto smallest = hn::Set(d, double{std::numeric_limits<float>::min()});
  alignas(64) double rows[12][poses_a_copy];
  bool all_valid = true;
  hn::VFromD<decltype(f)> least[3], most[3];
  for (int row = 0; row < 3; ++row) {
    least[row] = hn::Set(f, std::numeric_limits<float>::infinity());
    most[row] = hn::Neg(least[row]);
  }
  for (std::size_t k = 0; k < count; k += lanes) {
    if (k % poses_a_copy == 0)
      copy_numbers(first + k * stride, stride, std::min(poses_a_copy, count - k), next != nullptr ? next + k : nullptr,
                   rows);
    hn::VFromD<decltype(d)> x[12];
    for (std::size_t n = 0; n < 12; ++n) x[n] = hn::Load(d, rows[n] + k % poses_a_copy);
    const auto dot = [&](int i, int j) HWY_ATTR {
      return hn::Add(hn::Add(hn::Mul(x[3 * i], x[3 * j]), hn::Mul(x[3 * i + 1], x[3 * j + 1])),
                     hn::Mul(x[3 * i + 2], x[3 * j + 2]));
    };
    const auto mixed = [&](int i, int j, int k0) HWY_ATTR {
      return hn::Mul(x[6 + k0], hn::Sub(hn::Mul(x[i], x[3 + j]), hn::Mul(x[j], x[3 + i])));
    };
    // NaN fails each comparison.
    auto valid = hn::Le(hn::Abs(hn::Sub(dot(0, 0), one)), skew);
    valid = hn::And(valid, hn::Le(hn::Abs(hn::Sub(dot(1, 1), one)), skew));
    valid = hn::And(valid, hn::Le(hn::Abs(hn::Sub(dot(2, 2), one)), skew));
    valid = hn::And(valid, hn::Le(hn::Abs(dot(0, 1)), skew));
    valid = hn::And(valid, hn::Le(hn::Abs(dot(0, 2)), skew));
    valid = hn::And(valid, hn::Le(hn::Abs(dot(1, 2)), skew));
    valid = hn::And(valid, hn::Gt(hn::Add(hn::Add(mixed(1, 2, 0), mixed(2, 0, 1)), mixed(0, 1, 2)), hn::Zero(d)));
    for (int row = 0; row < 3; ++row) valid = hn::And(valid, hn::Le(hn::Abs(x[9 + row]), far));
    all_valid = all_valid && hn::AllTrue(d, valid);
    const auto up = [&](auto v) HWY_ATTR {
      v = hn::Add(v, hn::Add(hn::Mul(hn::Abs(v), last_bit), smallest));
      return hn::DemoteTo(f, hn::Min(hn::Max(v, hn::Neg(largest)), largest));
    };
    for (int row = 0; row < 3; ++row) {
      auto middle = x[9 + row], extent = radius;
      for (int column = 0; column < 3; ++column) {
        middle = hn::Add(middle, hn::Mul(x[3 * column + row], hn::Set(d, link->centre[column])));
        extent = hn::Add(extent, hn::Mul(hn::Abs(x[3 * column + row]), hn::Set(d, link->half[column])));
      }
      // What is written past the count is set later, or is room at the end.
      const auto lo = hn::Neg(up(hn::Sub(extent, middle))), hi = up(hn::Add(middle, extent));
      hn::StoreU(lo, f, boxes->lo(row) + at + k);
      hn::StoreU(hi, f, boxes->hi(row) + at + k);
      least[row] = hn::Min(least[row], lo);
      most[row] = hn::Max(most[row], hi);
    }
  }
  for (int row = 0; row < 3; ++row) {
    all->lo[static_cast<std::size_t>(row)] = hn::GetLane(hn::MinOfLanes(f, least[row]));
    all->hi[static_cast<std::size_t>(row)] = hn::GetLane(hn::MaxOfLanes(f, most[row]));
  }
  return all_valid;
}

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(link_boxes);

LinkBox::LinkBox(const Shape& link) : radius(link.rounding()) {
  const Bounds own = link.bounds(Pose{});
  centre = (own.lo + own.hi) / 2;
  half = (own.hi - own.lo) / 2 - Vec3::Constant(link.rounding());
  if (link.kind() == ShapeKind::sphere || link.kind() == ShapeKind::capsule) {
    half -= Vec3::Constant(link.radius());
    radius += link.radius();
  }
  half = half.cwiseMax(0.0);
}

bool link_boxes(const LinkBox& link, const Pose* first, std::size_t stride, std::size_t count, BoxArray& boxes,
                std::size_t at, const Pose* next, Aabb& all) {
  return HWY_DYNAMIC_DISPATCH(link_boxes)(&link, first, stride, count, &boxes, at, next, &all);
}

}  // namespace tandem
#endif
