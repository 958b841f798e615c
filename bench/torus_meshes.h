// The meshes of benches that go by size.
#pragma once
#include <cstddef>
#include <vector>

#include "benches.h"
#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

/// A torus with bumps, about three times as many cells round as across; solid. Of radius 1.32 and 0.32 thick or less.
Mesh bumpy_torus(std::size_t triangles);
/// Numbers of triangles: those asked for, else 10^3 to 5 * 10^6.
std::vector<std::size_t> mesh_sizes(const Settings& settings);
/// As files of triangles have it: each has corners of its own, in no order.
Mesh soup_of(const Mesh& mesh);

}  // namespace tandem::bench
