// A memory resource that queries reuse.
#pragma once
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <new>
#include <utility>

namespace tandem {

/// A block that is allocated from the front and free again once all of it has been returned. Requests that do not fit
/// come from `new`, and the block is larger next time. For one query at a time.
class QueryMemory final : public std::pmr::memory_resource {
 public:
  /// A usual size in bytes for contacts of a mesh with so many triangles: a torus half of which is in the ground takes
  /// 220 per triangle. Large meshes rarely overlap as much.
  static std::size_t usual(std::size_t triangles) { return std::clamp(384 * triangles, least, 16 * least); }

  /// Allocates the block, or the larger one that was needed (otherwise the first allocation does), and writes to its
  /// pages, so that no query waits for them. Nothing may be in use.
  void reserve(std::size_t bytes) {
    wanted_ = std::max(wanted_, bytes);
    reserve();
  }
  std::size_t memory() const { return size_; }  ///< bytes

 private:
  static constexpr std::size_t least = std::size_t{1} << 20;

  void reserve() {
    if (wanted_ <= size_) return;
    // If the allocation fails, it is not tried again.
    const std::size_t size = std::bit_ceil(std::exchange(wanted_, size_));
    block_ = std::make_unique<std::byte[]>(size);
    wanted_ = size_ = size;
  }
  void* do_allocate(std::size_t bytes, std::size_t alignment) override {
    if (pieces_ == 0 && spilled_ == 0) reserve();
    void* place = block_.get() + used_;
    std::size_t room = size_ - used_;
    if (std::align(alignment, bytes, place, room) == nullptr) {
      void* const spilled = ::operator new(bytes, std::align_val_t(alignment));
      spilled_ += bytes + alignment;
      wanted_ = std::max(wanted_, used_ + spilled_);
      return spilled;
    }
    used_ = size_ - room + bytes;
    ++pieces_;
    return place;
  }
  void do_deallocate(void* place, std::size_t bytes, std::size_t alignment) override {
    const auto at = reinterpret_cast<std::uintptr_t>(place), first = reinterpret_cast<std::uintptr_t>(block_.get());
    if (at < first || at >= first + size_) {
      spilled_ -= bytes + alignment;
      return ::operator delete(place, std::align_val_t(alignment));
    }
    if (--pieces_ == 0) used_ = 0;
  }
  bool do_is_equal(const std::pmr::memory_resource& other) const noexcept override { return this == &other; }

  std::unique_ptr<std::byte[]> block_;
  std::size_t size_ = 0, used_ = 0, pieces_ = 0;  // pieces: allocations in the block
  std::size_t spilled_ = 0, wanted_ = least;
};

}  // namespace tandem
