#pragma once
#include <cstdint>
#include <span>
#include <string>

namespace tandem::test {

/// Empty, or what is wrong with the answers for the pair that the bytes make, and its record. Always: exceptions,
/// numbers that are none, answers off by a thousandth of the size or other ones with A and B exchanged. Strictly: all
/// that judge() asks, of pairs whose sizes and aspects lie within 1e5 of each other, and 1e-7 of the rest.
std::string judge_bytes(std::span<const std::uint8_t> bytes, bool strictly);

}  // namespace tandem::test
