// A cosine for each triangle of a mesh, computed on demand and kept.
#pragma once
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <optional>

namespace tandem {

/// Since it is unknown how many triangles will be needed, each cosine is computed at its first use, from any thread;
/// two threads that compute the same one get the same result. Unused pages of memory are never touched.
class KeptCosines {
 public:
  explicit KeptCosines(std::size_t triangles)
      : kept_(static_cast<float*>(std::calloc(triangles, sizeof(float)))), size_(triangles) {
    if (kept_ == nullptr && triangles > 0) throw std::bad_alloc();
  }

  /// `find()` computes the triangle's cosine; empty if it has none.
  template <class Find>
  std::optional<double> of(std::uint32_t t, Find&& find) const {
    const std::atomic_ref<float> place(kept_.get()[t]);
    float stored = place.load(std::memory_order_relaxed);
    if (stored == not_computed) {
      const std::optional<double> found = find();
      // Rounded down, since it is a lower bound.
      stored = found ? std::nextafter(static_cast<float>(*found) + offset, 0.0f) : none;
      place.store(stored, std::memory_order_relaxed);
    }
    if (stored == none) return std::nullopt;
    return static_cast<double>(stored - offset);
  }
  std::size_t memory() const { return size_ * sizeof(float); }

 private:
  static constexpr float not_computed = 0, none = 1, offset = 4;  // outside the range of stored cosines

  struct Free {
    void operator()(float* p) const { std::free(p); }
  };
  std::unique_ptr<float[], Free> kept_;
  std::size_t size_;
};

}  // namespace tandem
