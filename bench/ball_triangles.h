// Triangles of a ball by rings, for the meshes of several benches.
#pragma once
#include <cstdint>

#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

/// Adds the triangles of a ball to a mesh whose vertices are in this order: the lower pole, rings - 1 circles of
/// `turns` vertices each from below, the upper pole. Adds 2 * turns * (rings - 1) triangles, oriented outward.
inline void add_ball_triangles(Mesh& mesh, int turns, int rings) {
  const auto at = [turns](int j, int i) { return static_cast<std::uint32_t>(1 + (j - 1) * turns + i % turns); };
  const auto top = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (int i = 0; i < turns; ++i) {
    mesh.triangles.push_back({0, at(1, i + 1), at(1, i)});
    mesh.triangles.push_back({at(rings - 1, i), at(rings - 1, i + 1), top});
    for (int j = 1; j + 1 < rings; ++j) {
      mesh.triangles.push_back({at(j, i), at(j, i + 1), at(j + 1, i + 1)});
      mesh.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j + 1, i)});
    }
  }
}

}  // namespace tandem::bench
