#pragma once
#include <cstddef>
#include <cstdint>

#include "support_map.h"

namespace tandem {

/// The number of the vertex farthest along d (x, y, z), among equals the first: of the dot products in double, summed
/// in order. The vertices are those that the map was made of.
using SupportKernel = std::uint32_t (*)(const SupportMap& map, const Vec3* vertices, const double* d);

/// The kernel for the widest instruction set of the processor (SSE2 to AVX-512). All give the same answer.
SupportKernel support_kernel();

/// Triangles from one apex: the planes of (from, to, apex), as arrays of x, y, z.
struct PlaneBatch {
  static constexpr std::size_t most = 16;
  alignas(64) double from[3][most] = {};
  alignas(64) double to[3][most] = {};
  alignas(64) double normal[3][most];  ///< unit, right-handed; 0 for a sliver
  alignas(64) double offset[most];     ///< normal . apex; infinite for a sliver
};

/// Fills normal and offset of the first `count` of a batch (and of what the last vector reaches), for the apex
/// (x, y, z). A sliver: the height over its longest edge from the apex is at most the square root of sliver2.
using PlaneKernel = void (*)(std::size_t count, double sliver2, double x, double y, double z, PlaneBatch& batch);
PlaneKernel plane_kernel();

}  // namespace tandem
