#pragma once
#include <cstddef>
#include <vector>

namespace tandem {

/// Bytes that a vector holds, used or not.
template <class T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace tandem
