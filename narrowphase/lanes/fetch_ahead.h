// Prefetching of memory.
#pragma once
#include <cstddef>
#include <span>

namespace tandem {

/// Prefetches memory that will be read soon, so that cache misses of separate arrays overlap. This function, and
/// functions that only call it, must be inlined: gcc drops calls of functions that change nothing.
template <class T>
[[gnu::always_inline]] inline void fetch_ahead(std::span<T> items) {
  constexpr std::size_t line = 64;
  const char* const first = reinterpret_cast<const char*>(items.data());
  for (std::size_t at = 0; at < items.size_bytes(); at += line) __builtin_prefetch(first + at);
}

}  // namespace tandem
