// A sheet of triangles for tests of deforming meshes.
#pragma once
#include <cstdint>

#include "tandem/narrowphase/shape.h"

namespace tandem::test {

/// A sheet of n x n squares, each two triangles, with the vertices vertex(x, y), x and y from -1 to 1.
template <class Vertex>
Mesh sheet(int n, const Vertex& vertex) {
  Mesh mesh;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) mesh.vertices.push_back(vertex(2.0 * i / n - 1, 2.0 * j / n - 1));
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

}  // namespace tandem::test
