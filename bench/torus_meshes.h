// Meshes of benches that vary the size.
#pragma once
#include <cstddef>
#include <vector>

#include "benches.h"
#include "tandem/narrowphase/shape.h"

namespace tandem::bench {

/// A torus with bumps, with about three times as many cells around as across; solid. Its radius is 1.32, its thickness
/// at most 0.32.
Mesh bumpy_torus(std::size_t triangles);
/// Numbers of triangles: those asked for, else 10^3 to 5 * 10^6.
std::vector<std::size_t> mesh_sizes(const Settings& settings);
/// The mesh as a triangle soup, as files of triangles have it: each triangle has vertices of its own, in no order.
Mesh soup_of(const Mesh& mesh);

}  // namespace tandem::bench
