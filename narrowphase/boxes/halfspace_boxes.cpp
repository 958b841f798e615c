// Half-spaces and boxes, a pair a lane (vector kernel).
#include "boxes/halfspace_boxes.h"

#include <algorithm>
#include <cstddef>

#include "manifold/manifold.h"
#include "tolerances.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "boxes/halfspace_boxes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "lanes/lane_vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace tandem::HWY_NAMESPACE {

#if !HWY_HAVE_SCALABLE

static_assert(HalfspaceBoxList::most % hn::MaxLanes(D()) == 0);

static_assert(offsetof(PlacedHalfspace, sense) == 7 * sizeof(double));

/// The pairs of a vector: half-spaces and boxes.
struct HalfspaceLanes {
  V plane[8], pose[12], half[4];
  // Height of the box's centre, slopes of its axes along the normal, distance of its lowest corner.
  V height, slope[3], distance;
  V lowest[3];                   // the lowest corner, in the box's frame
  V away[3];                     // the normal, from the first shape to the second

  HWY_INLINE void load(const HalfspaceBoxList& pairs, std::size_t at);
  HWY_INLINE void store_answers(std::size_t at, HalfspaceBoxFindings& found);
  HWY_INLINE void store_contacts(std::size_t at, double margin, HalfspaceBoxFindings& found) const;
};

HWY_INLINE void HalfspaceLanes::load(const HalfspaceBoxList& pairs, std::size_t at) {
  const auto nth = [&](std::size_t i) HWY_ATTR { return std::min(at + i, pairs.count - 1); };
  load_transposed([&](std::size_t i) HWY_ATTR { return pairs.halfspace[nth(i)]->normal.data(); }, plane);
  load_transposed([&](std::size_t i) HWY_ATTR { return pairs.pose[nth(i)]->rotation.data(); }, pose);
  load_transposed([&](std::size_t i) HWY_ATTR { return pairs.half[nth(i)]->data(); }, half);
  const V *const normal = plane, *const origin = plane + 4, offset = plane[3];
  V shift[3];
  for (int k = 0; k < 3; ++k) shift[k] = hn::Sub(pose[9 + k], origin[k]);
  height = hn::Sub(dot(normal, shift), offset);
  for (int k = 0; k < 3; ++k) {
    slope[k] = dot(pose + 3 * k, normal);
    lowest[k] = hn::CopySign(half[k], hn::Neg(slope[k]));
  }
  distance = hn::Add(height, dot(slope, lowest));
}

HWY_INLINE void HalfspaceLanes::store_answers(std::size_t at, HalfspaceBoxFindings& found) {
  const V *const normal = plane, sense = plane[7];
  const M box_first = hn::Lt(sense, number(0));
  V on_box[3], on_halfspace[3], first[3], second[3];
  place(pose, lowest, on_box);
  for (int k = 0; k < 3; ++k) {
    on_halfspace[k] = hn::Sub(on_box[k], hn::Mul(distance, normal[k]));
    first[k] = hn::IfThenElse(box_first, on_box[k], on_halfspace[k]);
    second[k] = hn::IfThenElse(box_first, on_halfspace[k], on_box[k]);
    away[k] = hn::Mul(sense, normal[k]);
  }
  store_in_turn(distance, first[0], first[1], first[2], at, found.answers.first);
  store_in_turn(second[0], second[1], second[2], away[0], at, found.answers.second);
}

/// As append_halfspace_box: the corners of the lowest face.
HWY_INLINE void HalfspaceLanes::store_contacts(std::size_t at, double margin, HalfspaceBoxFindings& found) const {
  const D d;
  const V zero = hn::Zero(d), one = number(1), least_depth = number(-margin);
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
  V kept[4], points = zero, deepest = number(-1e300), stands = deepest, standing = zero;
  M touches[4];
  const V diagonal = hn::Mul(number(2), hn::Sqrt(dot(half, half)));
  const V slack = hn::Mul(number(tolerance::alike), diagonal);
  for (int i = 0; i < 4; ++i) {
    const V side_u = number(i == 0 || i == 3 ? 1 : -1), side_w = i < 2 ? side : hn::Neg(side);
    const V depth = hn::Neg(hn::Add(hn::Add(middle, hn::Mul(side_u, rise_u)), hn::Mul(side_w, rise_w)));
    touches[i] = hn::Ge(depth, hn::Sub(least_depth, slack));
    kept[i] = hn::IfThenElse(hn::Lt(depth, least_depth), least_depth, depth);
    points = hn::Add(points, hn::IfThenElseZero(touches[i], one));
    deepest = hn::IfThenElse(touches[i], hn::Max(deepest, kept[i]), deepest);
    const M deeper = hn::And(touches[i], hn::Gt(kept[i], hn::Add(stands, slack)));
    stands = hn::IfThenElse(deeper, kept[i], stands);
    standing = hn::IfThenElse(deeper, number(i), standing);
    const V u = hn::Mul(side_u, half_u), w = hn::Mul(side_w, half_w), up = hn::Mul(number(0.5), depth);
    V corner[3] = {k.of(top, w, u), k.of(u, top, w), k.of(w, u, top)}, point[3];
    for (int c = 0; c < 3; ++c) corner[c] = hn::Add(corner[c], hn::Mul(up, slope[c]));
    place(pose, corner, point);
    store_in_turn(point[0], point[1], point[2], away[0], at, found.contacts[i].first);
  }
  const M patch = hn::Gt(points, number(2));
  const M wide = hn::Gt(hn::Min(half_u, half_w), hn::Mul(number(4 * thin), hn::Max(half_u, half_w)));
  const V face = hn::Add(hn::Add(axis, axis), hn::IfThenElseZero(hn::Lt(side, zero), one));
  std::uint8_t bits[5][8] = {};
  for (int i = 0; i < 4; ++i) {
    const M it = hn::And(patch, hn::Eq(standing, number(i)));
    store_in_turn(away[1], away[2], hn::IfThenElse(it, deepest, kept[i]),
                  whole_bits(hn::Add(hn::Mul(number(1 << 8), face), number(i))), at, found.contacts[i].second);
    hn::StoreMaskBits(d, hn::And(touches[i], hn::Le(distance, number(margin))), bits[i]);
  }
  hn::StoreMaskBits(d, hn::AndNot(wide, patch), bits[4]);
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    const auto bit = [&bits, lane](int i) { return bits[i][0] >> lane & 1; };
    found.corners[at + lane] = static_cast<std::uint8_t>(bit(0) | bit(1) << 1 | bit(2) << 2 | bit(3) << 3);
    found.known[at + lane] = bit(4) == 0;
  }
}

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void find_on_halfspaces(const HalfspaceBoxList& pairs, double margin, HalfspaceBoxFindings& found) {
  const D d;
  for (std::size_t at = 0; at < pairs.count; at += hn::Lanes(d)) {
    HalfspaceLanes lanes;
    lanes.load(pairs, at);
    hn::Store(lanes.distance, d, found.distance + at);
    if (hn::AllTrue(d, hn::Gt(lanes.distance, number(margin)))) {
      std::fill_n(found.known + at, hn::Lanes(d), true);
      continue;
    }
    lanes.store_answers(at, found);
    lanes.store_contacts(at, margin, found);
  }
}

#else

// NOLINTNEXTLINE(misc-definitions-in-headers): included once a target
void find_on_halfspaces(const HalfspaceBoxList& pairs, double, HalfspaceBoxFindings& found) {
  std::fill_n(found.known, pairs.count, false);
}

#endif

}  // namespace tandem::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tandem {
HWY_EXPORT(find_on_halfspaces);

void find_on_halfspaces(const HalfspaceBoxList& pairs, double margin, HalfspaceBoxFindings& found) {
  HWY_DYNAMIC_DISPATCH(find_on_halfspaces)(pairs, margin, found);
}
}  // namespace tandem
#endif
