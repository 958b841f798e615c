// Finds vertices with equal coordinates: a hash table with open addressing that several threads fill at once; it keeps
// the least index, whichever thread came first.
#include "shapes/vertex_weld.h"

#include <atomic>
#include <bit>

#include "shapes/mesh_model.h"
#include "shapes/run_parts.h"

namespace tandem {
namespace {

constexpr std::size_t ahead = 12;  // vertices

// Equal for equal coordinates, including -0 and 0.
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

  std::uint64_t mask() const { return slots_.size() - 1; }
  /// Prefetches the slot where a search begins.
  void fetch(std::size_t slot) const { __builtin_prefetch(&slots_[slot], 1); }
  /// Prefetches the vertex in that slot.
  void fetch_held(std::size_t slot) {
    const std::uint32_t held = std::atomic_ref(slots_[slot]).load(std::memory_order_relaxed);
    if (held != no_index) __builtin_prefetch(&vertices_[held]);
  }

  /// The slot of the vertices at this vertex's position; the search begins at `start`.
  std::size_t add(std::uint32_t vertex, std::size_t start) {
    const std::size_t mask = slots_.size() - 1;
    for (std::size_t s = start;; s = (s + 1) & mask) {
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
  run_chunks(parts, vertices.size(), elements_per_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    if (meter != nullptr) meter->spend(0);
    for (std::size_t v = begin; v < end; ++v) slots[v] = hash_of(vertices[v]) & table.mask();
    // For vertices in no order each search is a cache miss, so it is prefetched long before.
    for (std::size_t v = begin; v < end; ++v) {
      if (v + 2 * ahead < end) table.fetch(slots[v + 2 * ahead]);
      if (v + ahead < end) table.fetch_held(slots[v + ahead]);
      slots[v] = table.add(static_cast<std::uint32_t>(v), slots[v]);
    }
  });
  run_chunks(parts, vertices.size(), elements_per_chunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) first[v] = table.first_in(slots[v]);
  });
  return first;
}

}  // namespace tandem
