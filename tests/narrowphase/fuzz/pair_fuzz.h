#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace tandem::test {

/// What is asked of the answers, beside numbers that are some and no exceptions.
enum class Asked {
  /// Of shapes with sizes within 1e5 of each other that are nowhere thinner than a hundredth of their length: the
  /// truth to a thousandth of the size, and the same with A and B exchanged. No exceptions to it are known.
  of_plump,
  /// The same of all. Rare exceptions: segments and flat hulls in a cone, triangles and plates in round shapes.
  of_all,
  /// Strictly of pairs without a cylinder, cone or ellipsoid, else the truth to a thousandth of the size, of all.
  of_flat_strictly,
  /// All that judge() asks of pairs whose sizes and aspects lie within 1e5 of each other, and 1e-7 of the rest.
  strictly
};

/// Empty, or what is wrong with the answers for the pair that the bytes make, and its record.
std::string judge_bytes(std::span<const std::uint8_t> bytes, Asked asked);

}  // namespace tandem::test
