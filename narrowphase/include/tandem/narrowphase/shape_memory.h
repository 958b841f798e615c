// The memory of several shapes.
#pragma once
#include <cstddef>
#include <span>

#include "tandem/narrowphase/shape.h"

namespace tandem {

/// Heap memory of these shapes in bytes; data that several share, as copies do and a shape and its rounded version,
/// count once.
std::size_t memory_of(std::span<const Shape> shapes);

}  // namespace tandem
