// Lists whose elements are written once, by the threads that make them, and not before.
#pragma once
#include <memory>
#include <utility>
#include <vector>

namespace tandem {

/// Leaves new elements without a value where none is given: who resizes a list writes all of it.
template <class T>
struct UninitialisedAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UninitialisedAllocator<U>;
  };
  UninitialisedAllocator() = default;
  template <class U>
  UninitialisedAllocator(const UninitialisedAllocator<U>&) noexcept {}

  template <class U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Values>
  void construct(U* at, Values&&... values) {
    ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
  }
};

template <class T>
using UninitialisedList = std::vector<T, UninitialisedAllocator<T>>;

}  // namespace tandem
