#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// An edge of a polytope: of the directions in which it is the farthest, an arc from the normal of face[0] to that of
/// face[1].
struct FaceArc {
  std::uint8_t v[2];
  std::uint8_t face[2];
};

/// Of a box: face 2 k looks along its axis k, 2 k + 1 against it; bit k of a vertex says that it lies against axis k.
inline constexpr std::array<FaceArc, 12> box_arcs = [] {
  std::array<FaceArc, 12> arcs{};
  for (unsigned k = 0, n = 0; k < 3; ++k)
    for (unsigned s = 0; s < 4; ++s) {
      const unsigned i = (k + 1) % 3, j = (k + 2) % 3, at = (s & 1u) << i | s >> 1 << j;
      const auto small = [](unsigned x) { return static_cast<std::uint8_t>(x); };
      arcs[n++] = {{small(at), small(at | 1u << k)}, {small(2 * i + (s & 1u)), small(2 * j + (s >> 1))}};
    }
  return arcs;
}();

/// The faces and edges of a small polytope as a search for the least depth reads them.
struct FaceTable {
  static constexpr std::size_t most_faces = 128, most_vertices = 64;
  static constexpr std::size_t step = 16;  ///< faces are filled up to a multiple of it

  std::size_t faces = 0;      ///< 0: none are kept
  std::vector<float> planes;  ///< x, y, z of all normals, then offsets; after `faces` they are 0
  std::vector<FaceArc> arcs;

  std::size_t stride() const { return (faces + step - 1) / step * step; }
  void resize(std::size_t n) {
    faces = n;
    planes.assign(4 * stride(), 0.0f);
  }
  void set(std::size_t face, const Vec3& normal, double offset) {
    for (int k = 0; k < 3; ++k) planes[static_cast<std::size_t>(k) * stride() + face] = static_cast<float>(normal[k]);
    planes[3 * stride() + face] = static_cast<float>(offset);
  }
};

}  // namespace tandem
