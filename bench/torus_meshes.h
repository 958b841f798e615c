// The meshes of benches that go by size.
#pragma once
#include <cstddef>

#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

/// A torus with bumps, about three times as many cells round as across; solid. Of radius 1.32 and 0.32 thick or less.
Mesh bumpy_torus(std::size_t triangles);
/// As files of triangles have it: each has corners of its own, in no order.
Mesh soup_of(const Mesh& mesh);

}  // namespace tandem::bench
