// Rounds boxes outward to floats, several at once.
#pragma once
#include <cstddef>

namespace tandem {

/// The bounds of a few bodies in doubles, axis by axis.
struct BoundsRows {
  static constexpr std::size_t bodies = 64;
  alignas(64) double lo[3][bodies];
  alignas(64) double hi[3][bodies];
};

/// The boxes of bodies in rows, in single precision.
struct FloatRows {
  alignas(64) float lo[3][BoundsRows::bodies];
  alignas(64) float hi[3][BoundsRows::bodies];
};

/// Grows the boxes by `grow` (metres) on each side and rounds them outward: round_down(lo - grow), round_up(hi + grow),
/// several at once. Every number must be finite.
void round_outward(const BoundsRows& bounds, double grow, FloatRows& out);

}  // namespace tandem
