// What several shapes hold of memory.
#pragma once
#include <cstddef>
#include <span>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Bytes held beside these shapes; what several of them share, as copies do and a shape and its rounded one, once.
std::size_t memory_of(std::span<const Shape> shapes);

}  // namespace tandem
