#pragma once
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
