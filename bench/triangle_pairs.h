// Pairs of intersecting triangles, as benches compare them.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

using TrianglePairs = std::vector<std::array<std::uint32_t, 2>>;

inline std::uint64_t hash_of(const TrianglePairs& pairs) {
  std::uint64_t hash = pairs.size();
  for (const auto& [i, j] : pairs) hash = std::rotl(hash, 5) ^ ((std::uint64_t{i} << 32 | j) * 0x9e3779b97f4a7c15u);
  return hash;
}

/// True for a pair of a mesh with itself that counts: the lesser index first, no common vertex.
inline bool counts(const Mesh& mesh, std::uint32_t i, std::uint32_t j) {
  const auto &p = mesh.triangles[i], &q = mesh.triangles[j];
  return i < j && std::find_first_of(p.begin(), p.end(), q.begin(), q.end()) == p.end();
}

}  // namespace tandem::bench
