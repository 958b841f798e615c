// A table of open addressing that several threads fill at once: of vertices with equal coordinates it keeps the least
// index, whoever came first.
#include "shapes/vertex_weld.h"

#include <atomic>
#include <bit>

#include "shapes/mesh_model.h"
#include "shapes/run_parts.h"

namespace tandem {
namespace {

// Of equal coordinates, -0 and 0 among them, the same.
std::uint64_t hash_of(const Vec3& p) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(p[axis] + 0.0)) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 32;
  }
  return hash;
}

class VertexTable {
 public:
  explicit VertexTable(const std::vector<Vec3>& vertices)
      : vertices_(vertices), slots_(std::bit_ceil(2 * vertices.size() + 1), no_index) {}

  /// The slot of the vertices that are where this one is.
  std::size_t add(std::uint32_t vertex) {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t s = hash_of(vertices_[vertex]) & mask;; s = (s + 1) & mask) {
      const std::atomic_ref<std::uint32_t> slot(slots_[s]);
      std::uint32_t held = slot.load(std::memory_order_relaxed);
      if (held == no_index && slot.compare_exchange_strong(held, vertex, std::memory_order_relaxed)) return s;
      if (vertices_[held] != vertices_[vertex]) continue;
      while (vertex < held && !slot.compare_exchange_weak(held, vertex, std::memory_order_relaxed)) {
      }
      return s;
    }
  }
  std::uint32_t first_in(std::size_t slot) const { return slots_[slot]; }

 private:
  const std::vector<Vec3>& vertices_;
  std::vector<std::uint32_t> slots_;
};

}  // namespace

std::vector<std::uint32_t> weld(const std::vector<Vec3>& vertices, const PartRunner& parts, BuildMeter* meter) {
  VertexTable table(vertices);
  std::vector<std::uint32_t> first(vertices.size());
  UninitialisedList<std::size_t> slots(vertices.size());
  run_stretches(parts, vertices.size(), elements_a_stretch, [&](std::size_t, std::size_t begin, std::size_t end) {
    if (meter != nullptr) meter->spend(0);
    for (std::size_t v = begin; v < end; ++v) slots[v] = table.add(static_cast<std::uint32_t>(v));
  });
  run_stretches(parts, vertices.size(), elements_a_stretch, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) first[v] = table.first_in(slots[v]);
  });
  return first;
}

}  // namespace tandem
