// A quick separating axis test of several pairs of boxes at once.
#pragma once
#include <cstdint>

#include "boxes/box_lanes.h"
#include "tandem/narrowphase/answer.h"

namespace tandem {

/// Pairs of boxes that are tested together.
struct BoxPairList {
  static constexpr std::size_t most = 32;
  const Pose *pose_a[most], *pose_b[most];
  const HalfSize *half_a[most], *half_b[most];
  std::size_t count = 0;

  void add(const PlacedPair& pair) {
    pose_a[count] = pair.pose_a;
    pose_b[count] = pair.pose_b;
    half_a[count] = &pair.a->parameters();
    half_b[count++] = &pair.b->parameters();
  }
};

/// The separating axis test (Gottschalk 1996) of several pairs at once, a pair a lane. Bit i is set unless some axis
/// separates pair i by more than the margin and a bound on the rounding errors. Remaining pairs may be separated as
/// well: nearly parallel edges are left out, and machines without such vectors keep all pairs.
std::uint32_t screen_boxes(const BoxPairList& pairs, double margin);

/// The same; also puts the remaining pairs into columns of `rows`, from `column` on, each in the order of its boxes
/// that `boxes_reversed` requires. There must be room for `BoxPairList::most` columns, whose contents are lost.
std::uint32_t take_near_boxes(const BoxPairList& pairs, double margin, BoxPairRows& rows, std::size_t column);

}  // namespace tandem
