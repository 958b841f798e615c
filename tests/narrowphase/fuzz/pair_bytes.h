// Makes pairs of shapes from bytes, for fuzzing.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "pair_classes.h"

namespace tandem::test {

/// A pair of posed convex shapes from any bytes: simple numbers and any double, exact rotations and almost parallel
/// ones, sizes from 1e-12 to 1e12, poses that touch. Missing bytes are 0. Empty if the shapes are refused or there are
/// two half-spaces.
std::optional<reference::PosedPair> pair_from_bytes(std::span<const std::uint8_t> bytes);

}  // namespace tandem::test
