// Judges the narrow phase on pairs made from bytes.
#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace tandem::test {

/// The requirements on answers, in addition to being finite and without exceptions.
enum class Asked {
  /// For shapes with sizes within 1e5 of each other that are nowhere thinner than a hundredth of their length: right to
  /// a thousandth of the size, and the same with A and B exchanged. No violations are known.
  of_plump,
  /// The same for all. Rare violations: segments and flat hulls in a cone, triangles and plates in round shapes.
  of_all,
  /// Strict for pairs without a cylinder, cone or ellipsoid, else right to a thousandth of the size, for all.
  of_flat_strictly,
  /// All checks of judge() for pairs whose sizes and aspect ratios are within 1e5 of each other, and 1e-7 for the rest.
  strictly
};

/// The errors of the answers for the pair made from the bytes, and its record; empty if there are none.
std::string judge_bytes(std::span<const std::uint8_t> bytes, Asked asked);

}  // namespace tandem::test
