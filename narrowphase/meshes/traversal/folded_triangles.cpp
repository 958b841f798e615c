// Triangles of a mesh that its other triangles cancel.
#include "meshes/traversal/folded_triangles.h"

#include <algorithm>
#include <array>
#include <utility>

#include "shapes/metered_sort.h"

namespace tandem {
namespace {

// A triangle by its corners, sorted.
struct Sorted {
  std::array<std::uint32_t, 3> corners;
  std::uint32_t triangle;
  bool even;  // the orientation: the order of its corners is an even permutation
};

Sorted sorted(const MeshModel& mesh, std::uint32_t t) {
  const auto& v = mesh.triangles[t];
  Sorted s{{mesh.representative(v[0]), mesh.representative(v[1]), mesh.representative(v[2])}, t, true};
  for (const std::size_t i : {0u, 1u, 0u})
    if (s.corners[i] > s.corners[i + 1]) std::swap(s.corners[i], s.corners[i + 1]), s.even = !s.even;
  return s;
}

}  // namespace

FoldedTriangles::FoldedTriangles(const MeshModel& mesh, std::span<const TrianglePair> pairs, std::size_t side,
                                 WorkMeter& meter, std::pmr::memory_resource* memory)
    : folded_(memory) {
  std::pmr::vector<std::uint32_t> met(memory);
  met.reserve(pairs.size());
  for (const TrianglePair& pair : pairs) met.push_back(pair[side]);
  sort_metered(meter, met.begin(), met.end(), [](std::uint32_t x, std::uint32_t y) { return x < y; });
  met.erase(std::unique(met.begin(), met.end()), met.end());
  std::pmr::vector<Sorted> all(memory);
  all.reserve(met.size());
  for (const std::uint32_t t : met) all.push_back(sorted(mesh, t));
  sort_metered(meter, all.begin(), all.end(), [](const Sorted& x, const Sorted& y) {
    return x.corners != y.corners ? x.corners < y.corners : x.triangle < y.triangle;
  });
  for (auto from = all.begin(), to = from; from != all.end(); from = to) {
    to = std::find_if(from, all.end(), [&](const Sorted& s) { return s.corners != from->corners; });
    const auto even = std::count_if(from, to, [](const Sorted&s) { return s.even; }), odd = (to - from) - even;
    for (auto at = from; at != to; ++at)
      if (even != 0 && odd != 0 && !(at->even ? even > odd : odd > even)) folded_.push_back(at->triangle);
  }
  std::sort(folded_.begin(), folded_.end());
}

bool FoldedTriangles::contain(std::uint32_t triangle) const {
  return std::binary_search(folded_.begin(), folded_.end(), triangle);
}

}  // namespace tandem
