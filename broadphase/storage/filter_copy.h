#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "storage/memory.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

/// A copy of a filter's contents, to see later whether they changed.
class FilterCopy {
 public:
  void take(const PairFilter& filter) {
    group_.assign(filter.group.begin(), filter.group.end());
    mask_.assign(filter.mask.begin(), filter.mask.end());
    is_static_.assign(filter.is_static.begin(), filter.is_static.end());
  }
  /// Copies only the entries of some bodies: element k is that of bodies[k].
  void take(const PairFilter& filter, std::span<const std::uint32_t> bodies) {
    const auto some = [&](auto& mine, const auto& from) {
      mine.clear();
      if (from.empty()) return;
      for (const std::uint32_t body : bodies) mine.push_back(from[body]);
    };
    some(group_, filter.group);
    some(mask_, filter.mask);
    some(is_static_, filter.is_static);
  }
  /// Sets the entry of a body to element k of a copy for some bodies.
  void set(std::uint32_t body, const FilterCopy& some, std::size_t k) {
    if (!group_.empty()) group_[body] = some.group_[k];
    if (!mask_.empty()) mask_[body] = some.mask_[k];
    if (!is_static_.empty()) is_static_[body] = some.is_static_[k];
  }

  bool same_arrays(const PairFilter& filter) const {
    return group_.size() == filter.group.size() && mask_.size() == filter.mask.size() &&
           is_static_.size() == filter.is_static.size();
  }
  /// True if `filter` has the same entries for boxes [first, last); it must have the same arrays.
  bool same(const PairFilter& filter, std::size_t first, std::size_t last) const {
    const auto equal = [&](const auto& mine, const auto& now) {
      const auto from = static_cast<std::ptrdiff_t>(first), to = static_cast<std::ptrdiff_t>(last);
      return mine.empty() || std::equal(mine.begin() + from, mine.begin() + to, now.begin() + from);
    };
    return equal(group_, filter.group) && equal(mask_, filter.mask) && equal(is_static_, filter.is_static);
  }
  bool allows(std::uint32_t a, std::uint32_t b) const { return PairFilter{group_, mask_, is_static_}.allows(a, b); }
  PairFilter view() const { return {group_, mask_, is_static_}; }
  std::size_t memory() const { return bytes_of(group_) + bytes_of(mask_) + bytes_of(is_static_); }

 private:
  std::vector<std::uint32_t> group_, mask_;
  std::vector<std::uint8_t> is_static_;
};

}  // namespace tandem
