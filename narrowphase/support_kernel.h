#pragma once
#include <cstddef>
#include <cstdint>

namespace tandem {

/// The index of the candidate farthest along d = (x, y, z), among equals the first. `xyz`: `blocks` > 0 times
/// x[8], y[8], z[8], finite; `index`: 8 numbers a block.
using SupportKernel = std::uint32_t (*)(const double* xyz, const std::uint32_t* index, std::size_t blocks,
                                        const double* d);

/// The kernel for the widest instruction set of the processor (SSE2 to AVX-512). All give the same answer.
SupportKernel support_kernel();

}  // namespace tandem
