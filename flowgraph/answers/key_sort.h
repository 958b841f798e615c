// Sorts items by distinct unsigned keys.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace tandem {

/// So many items or fewer are sorted by insertion, without `spare`.
inline constexpr std::size_t most_by_insertion = 48;

/// Sorts by `key`, an unsigned number that differs from item to item: a few by insertion, more by a radix sort, a byte
/// at a time from the lowest, only the bytes that differ. Linear time, for one body (the ground) that meets all others.
/// `spare`: room for as many items, if they are more than most_by_insertion.
template <class Item, class Key>
void sort_by_key(std::span<Item> items, std::span<Item> spare, Key key) {
  if (items.size() <= most_by_insertion) {
    for (std::size_t i = 1; i < items.size(); ++i) {
      const Item item = items[i];
      std::size_t k = i;
      for (; k > 0 && key(items[k - 1]) > key(item); --k) items[k] = items[k - 1];
      items[k] = item;
    }
    return;
  }
  std::uint64_t differ = 0;
  for (const Item& item : items) differ |= key(item) ^ key(items.front());
  std::span<Item> from = items, to = spare;
  for (int shift = 0; shift < 64; shift += 8) {
    if ((differ >> shift & 0xffu) == 0) continue;
    const auto digit = [&](const Item& item) { return std::uint64_t{key(item)} >> shift & 0xffu; };
    std::array<std::uint32_t, 257> next{};
    for (const Item& item : from) ++next[digit(item) + 1];
    for (std::size_t i = 1; i < next.size(); ++i) next[i] += next[i - 1];
    for (const Item& item : from) to[next[digit(item)]++] = item;
    std::swap(from, to);
  }
  if (from.data() != items.data()) std::copy(from.begin(), from.end(), items.begin());
}

}  // namespace tandem
