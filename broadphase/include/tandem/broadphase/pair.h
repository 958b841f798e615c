// A pair of bodies.
#pragma once
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace tandem {

/// Two bodies by index, a < b.
struct Pair {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// The filter that decides which pairs exist. It is applied before a pair is made, so that a filtered pair costs no
/// narrow phase. Each array is empty (no such filter) or has one element a body.
struct PairFilter {
  std::span<const std::uint32_t> group;     ///< bits of the groups a body is in
  std::span<const std::uint32_t> mask;      ///< bits of the groups it may collide with; a pair needs both directions
  std::span<const std::uint8_t> is_static;  ///< bits, 1: static; two bodies that have a bit in common make no pair

  bool allows(std::uint32_t a, std::uint32_t b) const {
    if (!is_static.empty() && (is_static[a] & is_static[b]) != 0) return false;
    return group.empty() || ((group[a] & mask[b]) != 0 && (group[b] & mask[a]) != 0);
  }
};

/// A user's own filter, called for whole batches: moves the pairs to keep to the front, in their order, and returns how
/// many these are. Called from several threads at once. It may throw; the step then ends with that exception.
using PairPredicate = std::function<std::size_t(std::span<Pair>)>;

/// The output of a broad phase: a fixed buffer of pairs, which is handed on when it is full.
class PairSink {
 public:
  virtual ~PairSink() = default;
  /// Takes a candidate pair, in either order, and filters it; a != b.
  void put(std::uint32_t a, std::uint32_t b) {
    if (filter_->allows(a, b)) put_allowed(a < b ? Pair{a, b} : Pair{b, a});
  }
  /// Takes a pair that needs no filtering.
  void put_allowed(Pair pair) {
    buffer_[count_++] = pair;
    if (count_ == capacity_) full();
  }

 protected:
  /// Called with count_ == capacity_; must set buffer_, capacity_ and count_ so that there is room again.
  virtual void full() = 0;

  const PairFilter* filter_ = nullptr;
  Pair* buffer_ = nullptr;
  std::size_t capacity_ = 0;
  std::size_t count_ = 0;
};

}  // namespace tandem
