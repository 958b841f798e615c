// Memory of containers in bytes.
#pragma once
#include <cstddef>
#include <vector>

namespace tandem {

/// Bytes that a vector holds, used or not.
template <class T, class Allocator>
std::size_t bytes_of(const std::vector<T, Allocator>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace tandem
