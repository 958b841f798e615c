#include "halfspace_boxes.h"

#include <algorithm>

#include "manifold.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "halfspace_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

#if !HWY_HAVE_SCALABLE

static_assert(HalfspaceBoxRows::most % hn::MaxLanes(D()) == 0);

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void find_on_halfspaces(const HalfspaceBoxRows& pairs, std::size_t count, double margin, HalfspaceBoxFindings& found) {
  const D d;
  const V zero = hn::Zero(d), one = number(1), least_depth = number(-margin);
  for (std::size_t at = 0; at < count; at += hn::Lanes(d)) {
    V normal[3], origin[3], pose[12], half[3];
    load(pairs.normal, at, normal);
    load(pairs.origin, at, origin);
    load(pairs.pose, at, pose);
    load(pairs.half, at, half);
    V way[3], slope[3], lowest[3], on_box[3], on_halfspace[3];
    for (int k = 0; k < 3; ++k) way[k] = hn::Sub(pose[9 + k], origin[k]);
    const V height = hn::Sub(dot(normal, way), hn::Load(d, pairs.offset + at));
    for (int k = 0; k < 3; ++k) {
      slope[k] = dot(pose + 3 * k, normal);
      lowest[k] = hn::CopySign(half[k], hn::Neg(slope[k]));
    }
    const V distance = hn::Add(height, dot(slope, lowest));
    place(pose, lowest, on_box);
    for (int k = 0; k < 3; ++k) on_halfspace[k] = hn::Sub(on_box[k], hn::Mul(distance, normal[k]));

    // append_halfspace_box
    V steepest = hn::Abs(slope[0]), axis = zero;
    for (int k = 1; k < 3; ++k) {
      const V steep = hn::Abs(slope[k]);
      const M more = hn::Gt(steep, steepest);
      steepest = hn::IfThenElse(more, steep, steepest);
      axis = hn::IfThenElse(more, number(k), axis);
    }
    const Choice k(axis);
    const V down = k.own(slope), side = hn::CopySign(one, hn::Neg(down)), top = hn::Mul(side, k.own(half));
    const V half_u = k.next(half), half_w = k.last(half);
    const V middle = hn::Add(height, hn::Mul(hn::Mul(down, side), k.own(half)));
    const V rise_u = hn::Mul(k.next(slope), half_u), rise_w = hn::Mul(k.last(slope), half_w);
    V depth[4], kept[4], points = zero, deepest = number(-1e300), stands = deepest, standing = zero;
    M touches[4];
    const V diagonal = hn::Mul(number(2), hn::Sqrt(dot(half, half)));
    const V slack = hn::Mul(number(alike), diagonal);
    for (int i = 0; i < 4; ++i) {
      const V side_u = number(i == 0 || i == 3 ? 1 : -1), side_w = i < 2 ? side : hn::Neg(side);
      depth[i] = hn::Neg(hn::Add(hn::Add(middle, hn::Mul(side_u, rise_u)), hn::Mul(side_w, rise_w)));
      touches[i] = hn::Ge(depth[i], hn::Sub(least_depth, slack));
      kept[i] = hn::IfThenElse(hn::Lt(depth[i], least_depth), least_depth, depth[i]);
      points = hn::Add(points, hn::IfThenElseZero(touches[i], one));
      deepest = hn::IfThenElse(touches[i], hn::Max(deepest, kept[i]), deepest);
      const M deeper = hn::And(touches[i], hn::Gt(kept[i], hn::Add(stands, slack)));
      stands = hn::IfThenElse(deeper, kept[i], stands);
      standing = hn::IfThenElse(deeper, number(i), standing);
      const V u = hn::Mul(side_u, half_u), w = hn::Mul(side_w, half_w), up = hn::Mul(number(0.5), depth[i]);
      V corner[3] = {k.of(top, w, u), k.of(u, top, w), k.of(w, u, top)}, point[3];
      for (int c = 0; c < 3; ++c) corner[c] = hn::Add(corner[c], hn::Mul(up, slope[c]));
      place(pose, corner, point);
      store(point, at, found.point[i]);
    }
    const M patch = hn::Gt(points, number(2));
    const M wide = hn::Gt(hn::Min(half_u, half_w), hn::Mul(number(4 * thin), hn::Max(half_u, half_w)));
    std::uint8_t bits[5][8] = {};
    for (int i = 0; i < 4; ++i) {
      const M it = hn::And(patch, hn::Eq(standing, number(i)));
      hn::Store(hn::IfThenElse(it, deepest, kept[i]), d, found.depth[i] + at);
      hn::StoreMaskBits(d, hn::And(touches[i], hn::Le(distance, number(margin))), bits[i]);
    }
    hn::StoreMaskBits(d, hn::AndNot(wide, patch), bits[4]);
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
      const auto bit = [&bits, lane](int i) { return bits[i][0] >> lane & 1; };
      found.corners[at + lane] = static_cast<std::uint8_t>(bit(0) | bit(1) << 1 | bit(2) << 2 | bit(3) << 3);
      found.known[at + lane] = bit(4) == 0;
    }
    hn::Store(distance, d, found.distance + at);
    store(on_halfspace, at, found.on_halfspace);
    store(on_box, at, found.on_box);
    const V face = hn::Add(hn::Add(axis, axis), hn::IfThenElseZero(hn::Lt(side, zero), one));
    hn::Store(hn::Mul(number(1 << 8), face), d, found.face + at);
  }
}

#else

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void find_on_halfspaces(const HalfspaceBoxRows&, std::size_t count, double, HalfspaceBoxFindings& found) {
  std::fill_n(found.known, count, false);
}

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(find_on_halfspaces);

void HalfspaceBoxRows::set(std::size_t column, const Vec3& n, double n_offset, const Vec3& n_origin,
                           const HalfSize& half_size, const Pose& box) {
  offset[column] = n_offset;
  for (std::size_t k = 0; k < 9; ++k) pose[k][column] = box.rotation.data()[k];
  for (std::size_t k = 0; k < 3; ++k) {
    normal[k][column] = n.data()[k];
    origin[k][column] = n_origin.data()[k];
    pose[9 + k][column] = box.translation.data()[k];
    half[k][column] = half_size[k];
  }
}

void find_on_halfspaces(const HalfspaceBoxRows& pairs, std::size_t count, double margin, HalfspaceBoxFindings& found) {
  HWY_DYNAMIC_DISPATCH(find_on_halfspaces)(pairs, count, margin, found);
}
}  // namespace tandem
#endif
