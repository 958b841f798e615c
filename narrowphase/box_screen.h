#pragma once
#include <cstdint>
#include <span>

#include "box_axes.h"

namespace tandem {

/// Two posed boxes, by half sizes.
struct BoxPair {
  const HalfSize* half_a;
  const Pose* pose_a;
  const HalfSize* half_b;
  const Pose* pose_b;
};

/// Boxes that one call looks at.
constexpr std::size_t screened_boxes = 4;

/// The separating axis test (Gottschalk 1996) of `screened_boxes` pairs at once, a pair a lane: bit i is set where some
/// axis separates pair i by more than the margin and all that rounding may take from it. What is not set may be apart
/// as well: nearly parallel edges are left out, and machines without lanes of four doubles say nothing.
unsigned screen_boxes(const BoxPair* pairs, double margin);

}  // namespace tandem
