// A copy of a pair filter, for comparison in the next step.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "storage/memory.h"
#include "tandem/broadphase/pair.h"

namespace tandem {

/// A copy of a filter's contents, to see later whether they changed. If all bodies have the same group and mask, as in
/// most scenes, these are stored once.
class FilterCopy {
 public:
  void take(const PairFilter& filter) {
    size_ = filter.group.size();
    masks_ = filter.mask.size();
    is_static_.assign(filter.is_static.begin(), filter.is_static.end());
    one_ = one_of(filter);
    if (one_) return clear_groups();
    group_.assign(filter.group.begin(), filter.group.end());
    mask_.assign(filter.mask.begin(), filter.mask.end());
  }
  /// Copies only the entries of some bodies: element k is that of bodies[k].
  void take(const PairFilter& filter, std::span<const std::uint32_t> bodies) {
    const auto some = [&](auto& mine, const auto& from) {
      mine.clear();
      if (from.empty()) return;
      for (const std::uint32_t body : bodies) mine.push_back(from[body]);
    };
    one_.reset();
    some(group_, filter.group);
    some(mask_, filter.mask);
    some(is_static_, filter.is_static);
    size_ = group_.size();
    masks_ = mask_.size();
  }
  /// Sets the entry of a body to element k of a copy for some bodies.
  void set(std::uint32_t body, const FilterCopy& some, std::size_t k) {
    if (one_ && !some.group_.empty() && *one_ != Groups{some.group_[k], some.mask_[k]}) {
      std::vector<std::uint32_t> group(size_, one_->group), mask(size_, one_->mask);
      group_.swap(group);
      mask_.swap(mask);
      one_.reset();
    }
    if (!group_.empty()) group_[body] = some.group_[k];
    if (!mask_.empty()) mask_[body] = some.mask_[k];
    if (!is_static_.empty()) is_static_[body] = some.is_static_[k];
  }

  bool same_arrays(const PairFilter& filter) const {
    return size_ == filter.group.size() && masks_ == filter.mask.size() && is_static_.size() == filter.is_static.size();
  }
  /// True if `filter` has the same entries for boxes [first, last); it must have the same arrays.
  bool same(const PairFilter& filter, std::size_t first, std::size_t last) const {
    const auto equal = [&](const auto& mine, const auto& now) {
      const auto from = static_cast<std::ptrdiff_t>(first), to = static_cast<std::ptrdiff_t>(last);
      return mine.empty() || std::equal(mine.begin() + from, mine.begin() + to, now.begin() + from);
    };
    if (one_) {
      std::uint32_t differ = 0;
      for (std::size_t i = first; i < last; ++i)
        differ |= (filter.group[i] ^ one_->group) | (filter.mask[i] ^ one_->mask);
      if (differ != 0) return false;
    }
    return equal(group_, filter.group) && equal(mask_, filter.mask) && equal(is_static_, filter.is_static);
  }
  bool allows(std::uint32_t a, std::uint32_t b) const { return view().allows(a, b); }
  /// A filter that allows the same pairs; valid until this copy changes.
  PairFilter view() const { return {group_, mask_, is_static_}; }
  std::size_t memory() const { return bytes_of(group_) + bytes_of(mask_) + bytes_of(is_static_); }

 private:
  struct Groups {
    std::uint32_t group, mask;
    friend bool operator==(const Groups&, const Groups&) = default;
  };

  /// The group and mask of all bodies, if they are the same and let all bodies meet.
  static std::optional<Groups> one_of(const PairFilter& filter) {
    if (filter.group.empty() || filter.mask.size() != filter.group.size()) return {};
    const Groups first{filter.group[0], filter.mask[0]};
    std::uint32_t differ = 0;
    for (std::size_t i = 0; i < filter.group.size(); ++i)
      differ |= (filter.group[i] ^ first.group) | (filter.mask[i] ^ first.mask);
    return differ == 0 && (first.group & first.mask) != 0 ? std::optional(first) : std::nullopt;
  }
  void clear_groups() {
    group_.clear();
    mask_.clear();
  }

  std::size_t size_ = 0, masks_ = 0;  // number of bodies with a group, with a mask
  std::optional<Groups> one_;         // those of all bodies; group_ and mask_ are then empty
  std::vector<std::uint32_t> group_, mask_;
  std::vector<std::uint8_t> is_static_;
};

}  // namespace tandem
