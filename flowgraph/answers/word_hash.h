// A hash of answers: equal hashes mean equal bits, except that -0 counts as +0.
#pragma once
#include <bit>
#include <cstdint>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// FNV-1a over 64-bit words instead of bytes: eight times fewer multiplications.
class WordHash {
 public:
  WordHash() = default;
  /// Continues from the state of another hash.
  explicit WordHash(std::uint64_t value) : value_(value) {}
  void add(std::uint64_t word) {
    value_ = (value_ ^ word) * 0x100000001b3u;
    value_ ^= value_ >> 32;
  }
  // Adding zero turns -0 into +0, so that the two, which are equal, hash alike.
  void add(double x) { add(std::bit_cast<std::uint64_t>(x + 0.0)); }
  void add(const Vec3& v) {
    add(v.x());
    add(v.y());
    add(v.z());
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace tandem
