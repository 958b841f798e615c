// A hash map from indices, in order of insertion.
#pragma once
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory_resource>
#include <utility>
#include <vector>

#include "shapes/mesh_model.h"

namespace tandem {

/// A hash map from indices that keeps its entries in order of insertion, so that iteration depends only on what was
/// inserted. Open addressing; entries move when it grows.
template <class Value>
class IndexMap {
 public:
  /// `expected`: number of entries before it grows.
  explicit IndexMap(std::pmr::memory_resource* memory, std::size_t expected = 0)
      : entries_(memory), slots_(2 * std::bit_ceil(std::max(expected, usual)), no_index, memory) {
    entries_.reserve(std::max(expected, usual));
  }

  /// The value of `key`, inserted as `value` if the key is new; and whether it was.
  std::pair<Value&, bool> emplace(std::uint32_t key, const Value& value) {
    std::size_t s = slot(key);
    if (slots_[s] != no_index) return {entries_[slots_[s]].second, false};
    if (2 * entries_.size() >= slots_.size()) {
      grow();
      s = slot(key);
    }
    slots_[s] = static_cast<std::uint32_t>(entries_.size());
    entries_.emplace_back(key, value);
    return {entries_.back().second, true};
  }
  Value* find(std::uint32_t key) {
    const std::uint32_t at = slots_[slot(key)];
    return at == no_index ? nullptr : &entries_[at].second;
  }
  std::size_t size() const { return entries_.size(); }
  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }

 private:
  static constexpr std::size_t usual = 32;  // entries

  std::size_t slot(std::uint32_t key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t s = (key * 0x9e3779b1u >> 8) & mask;
    while (slots_[s] != no_index && entries_[slots_[s]].first != key) s = (s + 1) & mask;
    return s;
  }
  void grow() {
    slots_.assign(2 * slots_.size(), no_index);
    for (std::uint32_t i = 0; i < entries_.size(); ++i) slots_[slot(entries_[i].first)] = i;
  }

  std::pmr::vector<std::pair<std::uint32_t, Value>> entries_;
  std::pmr::vector<std::uint32_t> slots_;  // place in entries_, or no_index
};

}  // namespace tandem
