// Triangles of two meshes, by their numbers.
#pragma once
#include <array>
#include <cstdint>

namespace tandem {

using TrianglePair = std::array<std::uint32_t, 2>;  ///< of A, of B

}  // namespace tandem
