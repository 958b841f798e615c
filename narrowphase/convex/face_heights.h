// The heights of one polytope's vertices over the other's faces, in single precision.
#pragma once
#include <cstddef>
#include <cstdint>

#include "shapes/face_table.h"

namespace tandem {

/// The vertices of a small polytope in single precision.
struct SmallVertices {
  alignas(64) float x[FaceTable::most_vertices], y[FaceTable::most_vertices], z[FaceTable::most_vertices];
  std::size_t count = 0;
};

/// The planes of faces, as in FaceTable.
struct FacePlanes {
  const float* planes = nullptr;
  std::size_t faces = 0, stride = 0;
  float unit = 1;  ///< unit of the offsets
};

/// For each face, the other polytope's largest height above its plane.
struct FaceHeights {
  alignas(64) float at[FaceTable::most_faces];
  /// The vertex that reaches farthest, to 2^-16 of the lengths.
  alignas(64) std::int32_t vertex[FaceTable::most_faces];
  float least;  ///< the smallest height
};

/// Transforms the other's vertices by the matrix (rows) and the shift, and takes for each face the largest offset +
/// normal . vertex.
using HeightKernel = void (*)(const FacePlanes& planes, const SmallVertices& other, const float (&turn)[9],
                              const float (&shift)[3], SmallVertices& placed, FaceHeights& out);
HeightKernel height_kernel();

}  // namespace tandem
