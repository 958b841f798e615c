// The faces and edges of a small polytope, for the search for the least depth.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tandem/narrowphase/pose.h"

namespace tandem {

/// An edge of a polytope; from v[0] to v[1], face[0] is on the left, seen from outside. The directions in which it is
/// the farthest feature are an arc, from the normal of face[0] to that of face[1].
struct FaceArc {
  std::uint8_t v[2];
  std::uint8_t face[2];
};

/// The edges of a box: the normal of face 2 k is along axis k, that of 2 k + 1 against it; bit k of a vertex: it is on
/// the negative side of axis k.
inline constexpr std::array<FaceArc, 12> box_arcs = [] {
  std::array<FaceArc, 12> arcs{};
  for (unsigned k = 0, n = 0; k < 3; ++k)
    for (unsigned s = 0; s < 4; ++s) {
      const unsigned i = (k + 1) % 3, j = (k + 2) % 3, at = (s & 1u) << i | s >> 1 << j;
      const auto small = [](unsigned x) { return static_cast<std::uint8_t>(x); };
      const unsigned other = at | 1u << k;
      const bool along = (s & 1u) == s >> 1;  // the cross product of the faces' normals points along axis k
      arcs[n++] = {{small(along ? other : at), small(along ? at : other)},
                   {small(2 * i + (s & 1u)), small(2 * j + (s >> 1))}};
    }
  return arcs;
}();

/// The faces and edges of a small polytope in the layout of the search for the least depth.
struct FaceTable {
  static constexpr std::size_t most_faces = 128, most_vertices = 64;
  static constexpr std::size_t step = 16;  ///< the number of faces is padded to a multiple of it

  static constexpr float beyond = 8;  ///< in the table's unit vertices are less than 4 from the interior point

  std::size_t faces = 0;      ///< 0: not stored
  std::vector<float> planes;  ///< x, y, z of all normals, then offsets; padding: normal 0, offset `beyond`
  std::vector<FaceArc> arcs;

  std::size_t stride() const { return (faces + step - 1) / step * step; }
  void resize(std::size_t n) {
    faces = n;
    planes.assign(4 * stride(), 0.0f);
    std::fill(planes.end() - static_cast<std::ptrdiff_t>(stride()), planes.end(), beyond);
  }
  void set(std::size_t face, const Vec3& normal, double offset) {
    for (int k = 0; k < 3; ++k) planes[static_cast<std::size_t>(k) * stride() + face] = static_cast<float>(normal[k]);
    planes[3 * stride() + face] = static_cast<float>(offset);
  }
};

}  // namespace tandem
