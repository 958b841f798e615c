#pragma once
#include <cstddef>
#include <cstdint>

namespace tandem {

/// The index of the candidate farthest along d = (x, y, z), among equals the first. `xyz`: `blocks` > 0 times
/// x[8], y[8], z[8], finite; `index`: 8 numbers a block.
using SupportKernel = std::uint32_t (*)(const double* xyz, const std::uint32_t* index, std::size_t blocks, double x,
                                        double y, double z);

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
