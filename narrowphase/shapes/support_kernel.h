// Vector kernels of support functions.
#pragma once
#include <cstddef>
#include <cstdint>

#include "shapes/support_map.h"

namespace tandem {

/// The number of the vertex farthest along d (x, y, z), among equals the first: by dot products in double, summed in
/// order. The vertices are those that the map was made of.
using SupportKernel = std::uint32_t (*)(const SupportMap& map, const Vec3* vertices, const double* d);

/// The kernel for the widest instruction set of the processor (SSE2 to AVX-512). All give the same answer.
SupportKernel support_kernel();

namespace detail {
struct Hull;
}
using detail::Hull;

/// The number of the face whose normal is most aligned with d (x, y, z), among equals the first. The hull has
/// `normals`.
using FaceKernel = std::uint32_t (*)(const Hull& hull, const double* d);
FaceKernel face_kernel();

/// An upper bound on the vertices' support along d relative to the map's middle, at most about 1e-6 of their size too
/// large. Infinite for directions of extreme length.
using ReachKernel = double (*)(const SupportMap& map, const double* d);
ReachKernel reach_kernel();

/// The index of the least of `count` numbers below the limit, the first of equals; `count` if there is none.
using LeastKernel = std::size_t (*)(const double* values, std::size_t count, double limit);
LeastKernel least_kernel();

/// Triangles from one apex: the planes of (loop i, loop i + 1, apex), as arrays of x, y, z.
struct PlaneBatch {
  static constexpr std::size_t most = 16;
  alignas(64) double loop[3][most + 8] = {};
  alignas(64) double normal[3][most];  ///< unit, right-handed; 0 for a sliver
  alignas(64) double offset[most];     ///< normal . apex; infinite for a sliver
};

/// Sets normal and offset of the first `count` of a batch (and of the rest of the last vector), for the apex (x, y, z).
/// Sliver: the height over its longest edge from the apex is at most the square root of sliver2.
using PlaneKernel = void (*)(std::size_t count, double sliver2, double x, double y, double z, PlaneBatch& batch);
PlaneKernel plane_kernel();

}  // namespace tandem
