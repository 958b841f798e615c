// Lists whose elements are uninitialised until the threads that make them write them.
#pragma once
#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>
#ifdef __linux__
#include <sys/mman.h>
#endif

namespace tandem {

/// Memory for so many bytes, a few pages or more, in huge pages if the system has them: first writes cost as much as
/// the work itself, page by page, and threads wait for each other there.
inline void* allocate_large(std::size_t bytes, std::size_t page) {
  void* const at = ::operator new(bytes, std::align_val_t(page));
#ifdef __linux__
  madvise(at, bytes / page * page, MADV_HUGEPAGE);  // a failure changes nothing
#endif
  return at;
}

/// An allocator that leaves new elements uninitialised: after resizing, all elements must be written.
template <class T>
struct UninitialisedAllocator : std::allocator<T> {
  template <class U>
  struct rebind {
    using other = UninitialisedAllocator<U>;
  };
  UninitialisedAllocator() = default;
  template <class U>
  UninitialisedAllocator(const UninitialisedAllocator<U>&) noexcept {}

  T* allocate(std::size_t count) {
    if (!is_large(count)) return std::allocator<T>::allocate(count);
    return static_cast<T*>(allocate_large(count * sizeof(T), huge_page));
  }
  void deallocate(T* at, std::size_t count) noexcept {
    if (!is_large(count)) return std::allocator<T>::deallocate(at, count);
    ::operator delete(at, std::align_val_t(huge_page));
  }

  template <class U>
  void construct(U* at) noexcept {
    ::new (static_cast<void*>(at)) U;
  }
  template <class U, class... Values>
  void construct(U* at, Values&&... values) {
    ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
  }

 private:
  static constexpr std::size_t huge_page = std::size_t{1} << 21;  // bytes, on x86 and most others
  static bool is_large(std::size_t count) { return count >= 2 * huge_page / sizeof(T); }
};

template <class T>
using UninitialisedList = std::vector<T, UninitialisedAllocator<T>>;

}  // namespace tandem
