// Overlaps of a box with some hundred boxes, by sets of bits (Lakshman and Stiliadis, "High-speed policy-based packet
// forwarding using efficient multi-dimensional range matching", 1998).
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/broadphase/box_array.h"

namespace tandem {

/// Sets of boxes, a bit a box: each axis is divided into slabs of equal width; two sets per slab hold the boxes that
/// begin in it or before it, and those that end in it or after it. The boxes that may overlap a given one are the
/// intersection of six sets, two per axis.
class IntervalBits {
 public:
  static constexpr std::size_t most = 1024;  ///< boxes: for more a hierarchy is faster
  static constexpr std::size_t slabs = 64;   ///< along an axis

  /// The slabs in which a box ends (0, 2, 4) and begins (1, 3, 5).
  using Ends = std::array<std::uint8_t, 6>;
  /// The slabs of many boxes, one array per end.
  class EndsOfBoxes {
   public:
    Ends operator[](std::size_t box) const {
      return {ends_[0][box], ends_[1][box], ends_[2][box], ends_[3][box], ends_[4][box], ends_[5][box]};
    }
    std::size_t memory() const { return 6 * ends_[0].capacity(); }  ///< bytes held beside itself

   private:
    friend class IntervalBits;
    std::array<std::vector<std::uint8_t>, 6> ends_;
  };

  /// Builds the sets, unless there are more than `most` boxes or the slabs hardly separate them.
  void build(const BoxArray& boxes);
  bool is_built() const { return words_ != 0; }
  /// To be called after a box has changed; either may be empty.
  void move(std::uint32_t index, const Aabb& box);

  Ends ends_of(const Aabb& box) const;
  /// The ends of the first `count` boxes.
  void find_ends(const BoxArray& boxes, std::size_t count, EndsOfBoxes& out) const;

  /// Calls visit(index) for the boxes that may overlap the one with these ends, in ascending order, until it returns
  /// false, and returns that.
  template <class Visit>
  bool visit_near(const Ends& ends, const Visit& visit) const {
    std::array<const std::uint64_t*, 6> sets;
    for (std::size_t i = 0; i < 6; ++i) sets[i] = sets_.data() + (i * slabs + ends[i]) * words_;
    for (std::size_t word = 0; word < words_; ++word) {
      std::uint64_t left =
          sets[0][word] & sets[1][word] & sets[2][word] & sets[3][word] & sets[4][word] & sets[5][word];
      for (; left != 0; left &= left - 1)
        if (!visit(static_cast<std::uint32_t>(64 * word) + static_cast<std::uint32_t>(std::countr_zero(left))))
          return false;
    }
    return true;
  }

  std::size_t memory() const;  ///< bytes held beside itself

 private:
  /// The sets of an axis that hold a box: of those that begin, slab `begin` and all after it; of those that end, all
  /// slabs before `past`.
  struct Place {
    std::uint8_t begin = slabs, past = 0;  // in none
  };

  /// The slab of a coordinate, which does not fall as x rises: beyond the first or last slab it is that one; NaN is in
  /// the last.
  std::uint8_t slab(std::size_t axis, float x) const {
    const float off = std::clamp(x - origin_[axis], 0.0f, extent_[axis]) * per_metre_[axis];
    return static_cast<std::uint8_t>(std::min(static_cast<float>(slabs - 1), off));
  }
  bool divides(const BoxArray& boxes) const;
  void turn(std::size_t which, std::size_t first, std::size_t last, std::uint32_t index);

  std::size_t words_ = 0;  // of a set
  std::array<float, 3> origin_{}, extent_{}, per_metre_{};
  std::vector<std::uint64_t> sets_;  // axis 0 slab by slab: boxes that begin, boxes that end; then axes 1, 2
  std::vector<std::array<Place, 3>> places_;
};

}  // namespace tandem
