// Memory that a query takes and gives back, kept for the next ones.
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

/// One block, taken from the front and free again once all of it has been given back. What does not fit comes from
/// `new`, and the block is larger next time. For one query at a time.
class QueryMemory final : public std::pmr::memory_resource {
 public:
  /// Bytes that contacts of a mesh of so many triangles hardly exceed: a torus half of which is in the ground takes 220
  /// a triangle. Large ones are rarely as deep.
  static std::size_t usual(std::size_t triangles) { return std::clamp(384 * triangles, least, 16 * least); }

  /// Makes the block, or the larger one that was needed; else the first piece that is taken does. Its pages are written
  /// to, so that no query waits for them. Nothing may be in use.
  void reserve(std::size_t bytes) {
    wanted_ = std::max(wanted_, bytes);
    reserve();
  }
  std::size_t memory() const { return size_; }  ///< bytes

 private:
  static constexpr std::size_t least = std::size_t{1} << 20;

  void reserve() {
    if (wanted_ <= size_) return;
    const std::size_t size = std::bit_ceil(std::exchange(wanted_, size_));  // refused, it is not asked for again
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
  std::size_t size_ = 0, used_ = 0, pieces_ = 0;  // pieces: of the block that are not given back
  std::size_t spilled_ = 0, wanted_ = least;
};

}  // namespace tandem
