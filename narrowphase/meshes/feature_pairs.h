// Vertices and triangles, edges and edges of meshes within a margin.
#pragma once
#include <span>

#include "meshes/traversal/near_triangles.h"
#include "tandem/narrowphase/near_features.h"

namespace tandem {

/// The pairs of a mesh with itself. `first`: the representative of each vertex, by which features are named.
NearFeatures near_features(const MeshModel& mesh, std::span<const std::uint32_t> first, double margin,
                           const PartRunner& parts);

SearchEnd visit_near_features(const MeshModel& mesh, std::span<const std::uint32_t> first, double margin,
                              const NearFeatureVisitor& visitor, const SearchOptions& options);

/// Throws std::invalid_argument unless the margin is finite and >= 0.
void require_feature_margin(double margin);

}  // namespace tandem
