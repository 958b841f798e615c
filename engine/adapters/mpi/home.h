// The home rank of a pair.
#pragma once
#include <cstdint>

#include "tandem/mpi/contact_events.h"

namespace tandem::mpi {

/// The home rank of a pair, which every rank computes from the ids alone: the rank that knows something of the pair and
/// the rank that asks for it both send there.
inline int home(const IdPair& pair, int ranks) {
  std::uint64_t x = pair.a * 0x9e3779b97f4a7c15u ^ pair.b;
  x = (x ^ x >> 32) * 0xd6e8feb86659fd93u;
  return static_cast<int>((x ^ x >> 32) % static_cast<std::uint64_t>(ranks));
}

}  // namespace tandem::mpi
