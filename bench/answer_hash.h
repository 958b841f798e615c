// The hash of a contestant's answers, printed beside its time: FNV-1a over words of 64 bits, with the upper half mixed
// in.
#pragma once
#include <cstdint>

namespace tandem::bench {

inline constexpr std::uint64_t hash_start = 0xcbf29ce484222325u;

inline void add(std::uint64_t& hash, std::uint64_t word) {
  hash = (hash ^ word) * 0x100000001b3u;
  hash ^= hash >> 32;
}

}  // namespace tandem::bench
