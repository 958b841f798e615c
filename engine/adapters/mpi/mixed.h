// A hash of numbers that must be equal on all ranks.
#pragma once
#include <bit>
#include <cstdint>

namespace tandem::mpi {

/// The hash with one more number; -0 counts as 0.
inline std::uint64_t mixed(std::uint64_t hash, double x) {
  hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x100000001b3u;
  return hash ^ hash >> 32;
}

}  // namespace tandem::mpi
