#pragma once
#include <cstddef>
#include <cstdint>

#include "shapes/face_table.h"

namespace tandem {

/// Vertices of a small polytope in single precision.
struct SmallVertices {
  alignas(64) float x[FaceTable::most_vertices], y[FaceTable::most_vertices], z[FaceTable::most_vertices];
  std::size_t count = 0;
};

/// Planes of faces as FaceTable holds them.
struct FacePlanes {
  const float* planes = nullptr;
  std::size_t faces = 0, stride = 0;
  float unit = 1;  ///< of the offsets
};

/// For each face the other polytope's reach beyond its plane.
struct FaceHeights {
  alignas(64) float at[FaceTable::most_faces];
  alignas(64) std::int32_t vertex[FaceTable::most_faces];  ///< that reaches farthest, to 2^-16 of the lengths
  float least;                                             ///< of all
};

/// Places the other's vertices, turned by the matrix (rows) and shifted, and takes for each face the largest of
/// offset + normal . placed.
using HeightKernel = void (*)(const FacePlanes& planes, const SmallVertices& other, const float (&turn)[9],
                              const float (&shift)[3], SmallVertices& placed, FaceHeights& out);
HeightKernel height_kernel();

}  // namespace tandem
